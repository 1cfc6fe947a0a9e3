"""The contract's `error`, the rivals, and what is proven: better than each of them on unseen data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from incsvr.model.fitting import Fit
from incsvr.model.identification import Identification
from incsvr.model_trace.disturbance import disturbance
from incsvr.model_trace.held_out import Errors, beats_zero, horizons, trivial
from incsvr.model_trace.statistics import Change, change_of_rms, rms
from incsvr.model_trace.thresholds import INDEPENDENT_BLOCK_SCALES, TORQUE_BLOCK_SCALES
from incsvr.model_trace.unseen import Judge
from incsvr.numerics import Array, root_mean_square

PLAIN, EFFECTS, OUTPUT_ERROR = "plain", "effects", "plain, free inertia"
"""Names of the engine's models: the declared one with learned damping, with effects, and with a free inertia alone."""


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
    before = unseen.errors(plain)
    after = before if best == PLAIN else unseen.errors(model)
    alone = OUTPUT_ERROR if OUTPUT_ERROR in found.models else PLAIN  # the plain model reads no other velocity
    of_alone = (
        {PLAIN: before, best: after}[alone].free_run if alone in (PLAIN, best) else unseen.free_run(found.models[alone])
    )
    rivals = {"before": before.free_run, "output_error": of_alone, **_simple(before.measured)}
    free = _changes(rivals, after.free_run, INDEPENDENT_BLOCK_SCALES * unseen.scale / unseen.sample)
    left = np.concatenate(fitted.torque(model))
    floor = root_mean_square(left)
    if closed:
        better = found.found.fit if best != PLAIN else found.base
        before = replace(before, torque=unseen.next_samples(found.base))
        after = before if best == PLAIN else replace(after, torque=unseen.next_samples(better))
        floor = root_mean_square(np.concatenate(fitted.next_samples(better)))
    kept = {"hold": unseen.next_samples(found.base, keeps=True) if closed else _held(model, unseen)}
    torque = _changes({"before": before.torque, **kept}, after.torque, INDEPENDENT_BLOCK_SCALES / TORQUE_BLOCK_SCALES)
    of_simple = trivial(before.measured)
    sizes = {name: rms(errors) for name, errors in rivals.items()} | {"after": rms(after.free_run)}
    first = min(sizes, key=lambda name: (sizes[name], name != "after"))
    beside = {"free_run_rmse": sizes["output_error"]}
    error = {
        "before": before.to_dict(),
        "after": after.to_dict(),
        "change": {"torque_rmse": torque["before"].to_dict(), "free_run_rmse": free["before"].to_dict()},
        "floor": {"torque_rmse": floor},
        "trivial": {**of_simple, "output_error": beside, "axis_alone": beside},
        "best": {"name": first, "free_run_rmse": sizes[first]},
        "horizons": horizons(before.ahead, after.ahead),
        "validated_on": "blocks" if unseen.excluded else "recordings",
        "disturbance": disturbance(left, fitted.block, np.concatenate(fitted.efforts())),
    }
    if best == OUTPUT_ERROR:  # it is the model itself
        del free["output_error"]
    holds = all(change.high < 0.0 for change in (torque if closed else free).values())
    return Proof(error, before, after, holds and best != PLAIN and beats_zero(error))


def _simple(measured: Sequence[Array]) -> dict[str, Sequence[Array]]:
    """Errors of a velocity of zero, and of the first one kept."""
    return {"zero": measured, "hold": [piece - piece[0] for piece in measured]}


def _held(model: Fit, unseen: Judge) -> list[Array]:
    """The torque by which a velocity that is kept is wrong [N m]."""
    inertia = model.structure.inertia(model.theta, unseen.recordings.axis)
    return [inertia * each for each in unseen.torque(None)]


def _changes(rivals: Mapping[str, Sequence[Array]], after: Sequence[Array], length: float) -> dict[str, Change]:
    """The change from each rival's error to that of the model; `length` of independent blocks [samples]."""
    return {name: change_of_rms(each, after, max(round(length), 4)) for name, each in rivals.items()}
