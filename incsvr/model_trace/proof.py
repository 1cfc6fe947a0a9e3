"""The contract's `error`, the rivals, and what is proven: better than each of them on unseen data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
    free = _changes({name: each.free_run for name, each in named.items()} | _simple(before.measured), after.free_run,
                    INDEPENDENT_BLOCK_SCALES * unseen.scale / unseen.sample)  # fmt: skip
    torque = _changes({name: each.torque for name, each in named.items()} | _held(found, unseen), after.torque,
                      INDEPENDENT_BLOCK_SCALES / TORQUE_BLOCK_SCALES)  # fmt: skip
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
        "change": {"torque_rmse": torque[PLAIN].to_dict(), "free_run_rmse": free[PLAIN].to_dict()},
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
    decisive = torque if closed else free
    rivals = [change for name, change in decisive.items() if name not in _same(found)]
    holds = all(change.high < 0.0 for change in rivals)
    return Proof(error, before, after, holds and has_effects(found))


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


def _simple(measured: Sequence[Array]) -> dict[str, Sequence[Array]]:
    """Errors of a velocity of zero, and of the first one kept."""
    return {"zero": measured, "hold": [piece - piece[0] for piece in measured]}


def _held(found: Identification, unseen: Judge) -> dict[str, Sequence[Array]]:
    """The torque by which a velocity that is kept is wrong [N m]."""
    inertia = found.model.structure.inertia(found.model.theta, unseen.recordings.axis)
    return {"hold": [inertia * each for each in unseen.torque(None)]}


def _changes(rivals: Mapping[str, Sequence[Array]], after: Sequence[Array], length: float) -> dict[str, Change]:
    """The change from each rival's error to that of the model; `length` of independent blocks [samples]."""
    return {name: change_of_rms(each, after, max(round(length), 4)) for name, each in rivals.items()}
