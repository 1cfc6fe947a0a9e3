"""A learner's memory as it is taken up after a restart: only what a learner can have written is believed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import astuple, dataclass, field, replace
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning import checked_learner as guard
from incsvr.learning import learner
from incsvr.learning.checked_learner import Guarded
from incsvr.learning.driven_motion import WINDOW_SAMPLES, Recent
from incsvr.learning.learner import Settings, State
from incsvr.learning.model import Model
from incsvr.numerics.plain import UNLESS_EMPTY, from_plain, to_plain
from incsvr.signals.samples import Samples

MAX_COUNT = 2**53
"""The number above any count of a learner's life; whole numbers are exact in JSON up to it."""
WEIGHT_ROUNDING_PART = 1e-6
"""The part of its bound by which a weight may be beyond it: what the solver's arithmetic leaves."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Memory(Guarded):
    """What a learner keeps over a restart, beside what it has learned and what the checks remember."""

    revision: int  # what was published last
    covered: tuple[float | None, ...]  # (bins,) when each bin of the rate range was covered last [s]; None: never
    t: float | None  # the vehicle's time of the newest sample [s]
    thrust: Any = field(default=None, metadata=UNLESS_EMPTY)  # what the watch over the thrust knows
    # at its end: the samples on their way to the next batch, and how right forecasts were
    on_the_way: Any = field(default=None, metadata=UNLESS_EMPTY)
    forecast: Any = field(default=None, metadata=UNLESS_EMPTY)


def restore(memory: Mapping[str, Any] | None, settings: Settings) -> tuple[Memory, tuple[str, ...]]:
    """Reads what `LearnerNode.memory` gave; None begins anew.

    Returns:
        the memory, and remarks where another policy's goes on under this one.

    Raises:
        Exception: of any kind, where it is not what a learner under these settings can have written.
    """
    if memory is None:
        fresh = guard.begin(settings)
        return Memory(fresh.learner, fresh.checks, revision=0, covered=(None,) * settings.bins, t=None), ()
    known = from_plain(Memory, memory)
    policy, before = known.learner.policy, known.before
    state = learner.under_policy(settings, known.learner)
    before = None if before is None else learner.under_policy(settings, before)
    known = replace(known, learner=state, before=before)
    for name, number in (("revision", known.revision), ("iterations", state.iterations)):
        if not 0 <= number < MAX_COUNT:
            raise BadInput(f"its {name} is {number!r}, which is no count")
    for each in (state, before):
        if each is not None:
            _check_model(each.model, settings)
    if min(astuple(state.water)) < 0.0 or state.recent.yaw_rate.size >= WINDOW_SAMPLES:
        raise BadInput("its record of what moves the vehicle is invalid")
    json.dumps(to_plain(Guarded(state, known.checks, before)), allow_nan=False)
    if len(known.covered) != settings.bins:
        raise BadInput("its covered rates are not those of the configured bins")
    _check_next_iteration(state, settings)
    if policy == settings.policy:
        return known, ()
    return known, (
        f"revision {known.revision} was learned with policy {policy}; its {len(state.memory.served)} vectors are "
        f"samples of policy {settings.policy} from now on",
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
