"""The contract's `error`, the rivals, and what is proven: better than each of them on unseen data."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from incsvr.model.identification import PLAIN, Identification
from incsvr.numerics import Array, root_mean_square
from incsvr.tracing.disturbance import disturbance
from incsvr.tracing.held_out import Errors, beats_zero, horizons, trivial
from incsvr.tracing.statistics import Change, change_of_rms, rms
from incsvr.tracing.thresholds import TORQUE_BLOCK_SCALES
from incsvr.tracing.unseen import Judge

OUTPUT_ERROR = "plain, free inertia"
"""Name of the plain simulator where its inertia is free."""


@dataclass(frozen=True, slots=True)
class Proof:
    """The comparison on unseen data.

    Attributes:
        error: the contract's.
        before, after: errors of the declared model, and of the best simulator.
        proven: whether the model with the effects is better than each rival, each interval below zero.
    """

    error: dict[str, Any]
    before: Errors
    after: Errors
    proven: bool


def prove(found: Identification, best: str, unseen: Judge, fitted: Judge, closed: bool) -> Proof:
    """The errors of the models on unseen data.

    Args:
        best: name of the model with the effects.
        unseen: judges by recordings, or by folds, that the fits did not use.
        fitted: judges by the whole fits on the recordings that they used.
        closed: whether the torque answers the rate, so that predictions of the next sample decide.
    """
    model, plain = found.models[best], found.models[PLAIN]
    alone = OUTPUT_ERROR if OUTPUT_ERROR in found.models else PLAIN  # the plain model reads no other velocity
    named = {PLAIN: unseen.errors(plain)}
    for name in {alone, best} - {PLAIN}:
        named[name] = unseen.errors(found.models[name], free_runs_alone=name != best)
    hold = held(unseen, model.structure.inertia(model.theta, unseen.recordings.axis))
    left = np.concatenate(fitted.torque(model))
    floor = root_mean_square(left)
    if closed:
        better = {PLAIN: found.base, best: found.found.fit if best != PLAIN else found.base}
        for name, predictor in better.items():
            named[name] = replace(named[name], torque=unseen.next_samples(predictor))
        floor = root_mean_square(np.concatenate(fitted.next_samples(better[best])))
        hold = unseen.next_samples(found.base, keeps=True)
    before, after = named[PLAIN], named[best]
    changes = compared(named, best, unseen, hold)
    sizes = {name: rms(each.free_run) for name, each in named.items()}
    of_simple = trivial(before.measured)
    every = {name: each["free_run_rmse"] for name, each in of_simple.items()}
    every |= {"output_error": sizes[alone], "before": sizes[PLAIN], "after": sizes[best]}
    first = min(every, key=lambda name: (every[name], name != "after"))
    beside = {"free_run_rmse": sizes[alone]}
    error = {
        "before": before.to_dict(),
        "after": after.to_dict(),
        "change": changes.of(PLAIN),
        "floor": {"torque_rmse": floor},
        "trivial": {**of_simple, "output_error": beside, "axis_alone": beside},
        "best": {"name": first, "free_run_rmse": every[first]},
        "horizons": horizons(before.ahead, after.ahead),
        "validated_on": "blocks" if unseen.excluded else "recordings",
        "disturbance": disturbance(left, fitted.block, np.concatenate(fitted.efforts())),
    }
    proven = best != PLAIN and changes.all_better(closed, {best}) and beats_zero(error)
    return Proof(error, before, after, proven)


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


def compared(
    named: Mapping[str, Errors],
    model: str,
    unseen: Judge,
    hold: Sequence[Array],
    block: float = 4.0,  # time scales whose differences count as independent: well above the errors' correlation time
) -> Changes:
    """The changes to one model from the others, from a velocity of zero, and from the first one kept.

    Args:
        named: errors of models, on the same data; of some the free runs alone.
        model: the name of the one.
        unseen: judges on these data.
        hold: the errors of the torque where the velocity stays as it is [N m].
    """
    measured, after = named[model].measured, named[model]
    free = {name: each.free_run for name, each in named.items()}
    free |= {"zero": measured, "hold": tuple(piece - piece[0] for piece in measured)}
    torque = {name: each.torque for name, each in named.items() if each.torque} | {"hold": tuple(hold)}
    return Changes(
        _changes(free, after.free_run, block * unseen.scale / unseen.sample),
        _changes(torque, after.torque, block / TORQUE_BLOCK_SCALES),
    )


def held(unseen: Judge, inertia: float) -> tuple[Array, ...]:
    """The torque by which a velocity that is kept over a block is wrong [N m]; of an inertia [kg m²]."""
    return tuple(inertia * each for each in unseen.torque(None))


def _changes(rivals: Mapping[str, Sequence[Array]], after: Sequence[Array], length: float) -> dict[str, Change]:
    """The change from each rival's error to that of the model; `length` of independent blocks [samples]."""
    return {name: change_of_rms(each, after, max(round(length), 4)) for name, each in rivals.items()}
