"""The contract's `error`, the rivals, and what is proven: better than each of them on unseen data."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from incsvr.model.identification import Identification
from incsvr.model_trace.disturbance import disturbance
from incsvr.model_trace.held_out import Errors, horizons, trivial
from incsvr.model_trace.statistics import Change, change_of_rms
from incsvr.model_trace.thresholds import INDEPENDENT_BLOCK_SCALES, TORQUE_BLOCK_SCALES
from incsvr.model_trace.unseen import Judge
from incsvr.numerics import Array, root_mean_square

PLAIN, OUTPUT_ERROR = "plain", "plain, free inertia"
"""Names of the engine's models: the declared one with learned damping, and the same with a free inertia."""


@dataclass(frozen=True, slots=True)
class Proof:
    """The comparison on unseen data.

    Attributes:
        error: the contract's.
        before, after: errors of the declared model, and of the best simulator.
        proven: whether the model with all effects is better than each rival, each interval below zero.
    """

    error: dict[str, Any]
    before: Errors
    after: Errors
    proven: bool


def prove(found: Identification, unseen: Judge, fitted: Judge, closed: bool) -> Proof:
    """The errors of the models on unseen data.

    Args:
        unseen: judges by recordings, or by folds, that the fits did not use.
        fitted: judges by the whole fits on the recordings that they used.
        closed: whether the torque answers the rate, so that predictions decide.
    """
    named = {name: unseen.errors(model) for name, model in found.models.items() if name in _judged(found)}
    before, after = named[PLAIN], named[found.best]
    inertia = found.model.structure.inertia(found.model.theta, unseen.recordings.axis)
    changes = compared(named, found.best, unseen, inertia)
    left = np.concatenate(fitted.torque(found.model))
    sizes = {name: each.to_dict()["free_run_rmse"] for name, each in named.items()}
    of_simple = trivial(before.measured)
    alone = OUTPUT_ERROR if OUTPUT_ERROR in named else PLAIN  # of one axis the plain model reads no other velocity
    every = {name: each["free_run_rmse"] for name, each in of_simple.items()}
    every |= {"output_error": sizes[alone], "before": sizes[PLAIN], "after": sizes[found.best]}
    best = min(every, key=lambda name: (every[name], name != "after"))
    error = {
        "before": before.to_dict(),
        "after": after.to_dict(),
        "change": changes.of(PLAIN),
        "floor": {"torque_rmse": root_mean_square(left)},
        "trivial": {
            **of_simple,
            "output_error": {"free_run_rmse": sizes[alone]},
            "axis_alone": {"free_run_rmse": sizes[alone]},
        },
        "best": {"name": best, "free_run_rmse": every[best]},
        "horizons": horizons(before.ahead, after.ahead),
        "validated_on": "blocks" if unseen.excluded else "recordings",
        "disturbance": disturbance(left, fitted.block, np.concatenate(fitted.efforts())),
    }
    better = changes.all_better(closed, _same(found))
    return Proof(error, before, after, better and has_effects(found))


def has_effects(found: Identification) -> bool:
    """Whether the best simulator has every effect that was added, and any was."""
    keys = {key for each in found.found.added for key in each.candidate.start}
    inertia_alone = all(key.startswith("mass:") for key in keys) and keys <= set(found.model.names)
    return bool(keys) and (found.best.startswith("effects") or inertia_alone)


def _judged(found: Identification) -> set[str]:
    return {PLAIN, OUTPUT_ERROR, found.best}


def _same(found: Identification) -> set[str]:
    """Names of models that are the best one itself: where the inertia alone was added, output error is the model."""
    own = found.model
    return {
        name
        for name, each in found.models.items()
        if set(each.names) == set(own.names) and each.structure.shift_priors == own.structure.shift_priors
    }


@dataclass(frozen=True, slots=True)
class Changes:
    """The changes from each rival's errors to a model's, by the rival's name.

    Attributes:
        free: of free runs [rad/s].
        torque: of the predicted torque [N m].
    """

    free: Mapping[str, Change]
    torque: Mapping[str, Change]

    def all_better(self, closed: bool, same: Collection[str] = ()) -> bool:
        """Whether the model is better than each rival, but for those that are the same model: what proves it.

        Args:
            closed: whether the torque answers the rate, so that predictions decide, else free runs.
        """
        decisive = self.torque if closed else self.free
        return all(change.high < 0.0 for name, change in decisive.items() if name not in same)

    def of(self, rival: str) -> dict[str, dict[str, float]]:
        """The contract's `change`, from one rival."""
        return {"torque_rmse": self.torque[rival].to_dict(), "free_run_rmse": self.free[rival].to_dict()}


def compared(named: Mapping[str, Errors], model: str, unseen: Judge, inertia: float) -> Changes:
    """The changes to one model from the others, from a velocity of zero, and from the first one kept.

    Args:
        named: errors of models, on the same data.
        model: the name of the one.
        unseen: judges on these data.
        inertia: of the model [kg m²].
    """
    measured, after = named[model].measured, named[model]
    hold = [inertia * each for each in unseen.torque(None)]
    free = {name: each.free_run for name, each in named.items()}
    free |= {"zero": measured, "hold": tuple(piece - piece[0] for piece in measured)}
    torque = {name: each.torque for name, each in named.items()} | {"hold": tuple(hold)}
    return Changes(
        _changes(free, after.free_run, INDEPENDENT_BLOCK_SCALES * unseen.scale / unseen.sample),
        _changes(torque, after.torque, INDEPENDENT_BLOCK_SCALES / TORQUE_BLOCK_SCALES),
    )


def _changes(rivals: Mapping[str, Sequence[Array]], after: Sequence[Array], length: float) -> dict[str, Change]:
    """The change from each rival's error to that of the model; `length` of independent blocks [samples]."""
    return {name: change_of_rms(each, after, max(round(length), 4)) for name, each in rivals.items()}
