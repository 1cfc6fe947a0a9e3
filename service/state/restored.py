"""A learner's memory as it is taken up after a restart: only what a learner can have written is believed."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import astuple, dataclass, replace
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning import checked_learner as guard
from incsvr.learning import learner
from incsvr.learning.checked_learner import Guarded
from incsvr.learning.driven_motion import WINDOW_SAMPLES, Recent
from incsvr.learning.learner import Settings, State
from incsvr.learning.model import Model
from incsvr.numerics import Array
from incsvr.numerics.plain import from_plain, to_plain
from incsvr.signals.samples import Samples

MAX_COUNT = 2**53
"""The number above any count of a learner's life; whole numbers are exact in JSON up to it."""
WEIGHT_ROUNDING_PART = 1e-6
"""The part of its bound by which a weight may be beyond it: what the solver's arithmetic leaves."""


@dataclass(frozen=True, slots=True)
class RestoredMemory:
    """The memory that a learner continues.

    Attributes:
        guarded: what it has learned, and what the checks remember.
        covered: (bins,) when each bin of the rate range was covered last [s], −∞ where it never was.
        revision: what was published last.
        t: the vehicle's time of the newest sample in it [s].
        on_the_way: the samples on their way to the next batch, as plain data.
        remark: a sentence where another policy's memory goes on under this one.
    """

    guarded: Guarded
    covered: Array
    revision: int = 0
    t: float | None = None
    on_the_way: Mapping[str, Any] | None = None
    remark: str | None = None


def restore(memory: Mapping[str, Any] | None, settings: Settings) -> RestoredMemory:
    """Reads what `LearnerNode.memory` gave; None begins anew.

    Raises:
        Exception: of any kind, where it is not what a learner under these settings can have written.
    """
    if memory is None:
        return RestoredMemory(guard.begin(settings), np.full(settings.bins, -math.inf))
    guarded = from_plain(Guarded, memory)
    policy, before = guarded.learner.policy, guarded.before
    state = learner.under_policy(settings, guarded.learner)
    guarded = replace(guarded, learner=state, before=None if before is None else learner.under_policy(settings, before))
    for name, number in (("revision", memory["revision"]), ("iterations", state.iterations)):
        if type(number) is not int or not 0 <= number < MAX_COUNT:
            raise BadInput(f"its {name} is {number!r}, which is no count")
    _check_model(state.model, settings)
    if guarded.before is not None:
        _check_model(guarded.before.model, settings)
    if min(astuple(state.water)) < 0.0 or state.recent.yaw_rate.size >= WINDOW_SAMPLES:
        raise BadInput("its record of what moves the vehicle is invalid")
    json.dumps(to_plain(guarded), allow_nan=False)
    covered = np.array([-math.inf if t is None else float(t) for t in memory["covered"]])
    if covered.size != settings.bins or np.isnan(covered).any():
        raise BadInput("its covered rates are not those of the configured bins")
    t = None if memory["t"] is None else float(memory["t"])
    if t is not None and not math.isfinite(t):
        raise BadInput(f"its newest sample is of the time {t}")
    _check_next_iteration(state, settings)
    remark = (
        f"revision {memory['revision']} was learned with policy {policy}; its {len(state.memory.served)} vectors are "
        f"samples of policy {settings.policy} from now on"
    )
    return RestoredMemory(
        guarded, covered, memory["revision"], t, memory.get("on_the_way"), remark if policy != settings.policy else None
    )


def _check_model(model: Model, settings: Settings) -> None:
    """The model is one that these settings allow."""
    arrays = (model.support_rate, model.support_damping, model.weight, model.count)
    if any(array.shape != model.support_rate.shape or not np.isfinite(array).all() for array in arrays):
        raise BadInput("its model contains a value that is no number")
    if (model.gamma, model.C, model.epsilon) != (settings.gamma, settings.C, settings.epsilon):
        raise BadInput("its model was learned under other settings")
    others = () if model.several is None else model.several.others
    if model.is_trained and others != settings.others:
        raise BadInput(f"its model was learned over {', '.join(others) or 'the own velocity alone'}")
    if model.several is not None and not model.several.possible(model.support_rate):
        raise BadInput("its model's further velocities are invalid")
    if (model.count <= 0.0).any() or (
        np.abs(model.weight) > settings.C * model.count * (1.0 + WEIGHT_ROUNDING_PART)
    ).any():
        raise BadInput("its model contains a weight beyond C times its number of samples")
    if not 0.0 <= model.correlation < 1.0 or min(astuple(model.water)) < 0.0:
        raise BadInput("its model contains an invalid noise")
    if not model.spread.possible:
        raise BadInput("its model contains an invalid uncertainty")
    if model.sigma < 0.0 or not model.certified_error >= 0.0:
        raise BadInput("its model contains a negative error")


def _check_next_iteration(state: State, settings: Settings) -> None:
    """Checks that another iteration can follow, with and without new samples; its result is dropped.

    Two samples alone are too few to tell what moved them, and are taken for evidence.
    """
    rate = np.array(settings.rate_range)
    two = Samples(np.array([0.0, 1.0]), rate, np.zeros(2), {name: np.ones(2) for name in settings.others})
    if state.model.is_trained:
        two = replace(two, damping=state.model.learned(two))
    learner.step(settings, state, two)
    learner.step(settings, replace(state, recent=Recent()), two)
