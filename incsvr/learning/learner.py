"""One iteration of Fig. 3 as a value: state in, batch in → state and `Iteration` out.

    state = start(settings)
    for batch in batches:
        state, iteration = step(settings, state, batch)

Only motion that the torque makes is learned from (driven_motion.py): such samples wait until a policy has enough of
them.

There is no clock and no randomness: the same batches give the same models to the bit, also when the state has been
written to a file and read back in between.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.learning import paper, weighted
from incsvr.learning.driven_motion import Recent, sift
from incsvr.learning.dual import MAX_INPUT_NORM
from incsvr.learning.excitation import Water
from incsvr.learning.freeing import by_itself
from incsvr.learning.iteration import Iteration, Settings
from incsvr.learning.model import Model
from incsvr.learning.noise import Mask
from incsvr.numerics import Array
from incsvr.numerics.plain import fields_from_plain, fields_to_plain, from_plain
from incsvr.signals.samples import Samples

__all__ = ["Iteration", "Settings", "State", "start", "step"]

STATE_FORM = 3
"""Number of the form of the plain data; a state of another form is refused."""
BATCH_PARTS = 5
"""Parts of a batch of which a policy learns from one at least: from fewer samples no noise can be told."""


@dataclass(frozen=True, slots=True)
class Waiting:
    """Samples that the torque made and that no policy has learned from yet."""

    time: Array = field(default_factory=lambda: np.empty(0))  # (n,) [s]
    yaw_rate: Array = field(default_factory=lambda: np.empty(0))  # (n,) [rad/s]
    damping: Array = field(default_factory=lambda: np.empty(0))  # (n,) [N m]
    # (n,) where each stands in the stream, counted from the first sample of the next batch: negative
    place: NDArray[np.intp] = field(default_factory=lambda: np.empty(0, dtype=np.intp))
    others: Mapping[str, Array] = field(default_factory=dict)  # (n,) of each further velocity

    def with_batch(self, batch: Samples, driven: Mask) -> tuple[Samples, NDArray[np.intp]]:
        """These and the driven ones of a batch of (m,) samples, and their places from the first of this batch on."""
        place = np.flatnonzero(driven)
        if not self.time.size:
            return (batch if place.size == len(batch) else batch.take(place)), place
        known = Samples(self.time, self.yaw_rate, self.damping, self.others)
        return Samples.concatenate((known, batch.take(place))), np.concatenate((self.place, place))


@dataclass(frozen=True, slots=True)
class State:
    """The memory of the learner between two iterations; its size is bounded by the settings."""

    iterations: int  # how many have been done
    model: Model  # what is served
    policy: str  # whose memory it is
    memory: Any  # what the policy carries over, its `Memory`
    recent: Recent = field(default_factory=Recent)  # the last samples, for telling what the torque makes
    waiting: Waiting = field(default_factory=Waiting)  # samples that the torque made, fewer than the policy learns from
    water: Water = field(default_factory=Water)  # the motion that was no evidence

    def to_dict(self) -> dict[str, Any]:
        """Plain data for a file: numbers, strings, lists, dictionaries; exact to the bit through JSON."""
        return {"form": STATE_FORM, **fields_to_plain(self)}

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> State:
        if data.get("form") != STATE_FORM or data.get("policy") not in _POLICIES:
            raise BadInput("this is not a learner's state of this version; start from an empty state directory")
        memory = from_plain(_POLICIES[data["policy"]].Memory, data["memory"])
        return fields_from_plain(State, {**data, "memory": memory})


_POLICIES: dict[str, Any] = {"paper": paper, "weighted": weighted}


def start(settings: Settings) -> State:
    """The state before the first iteration: nothing learned."""
    model = Model.untrained(settings.gamma, settings.C, settings.epsilon)
    return State(0, model, settings.policy, _POLICIES[settings.policy].start(settings))


def under_policy(settings: Settings, state: State) -> State:
    """The state under the policy of the settings: another policy's vectors become samples of its memory."""
    if state.policy == settings.policy:
        return state
    memory = _POLICIES[settings.policy].continued(settings, state.memory)
    return replace(state, policy=settings.policy, memory=memory)


def step(settings: Settings, state: State, batch: Samples) -> tuple[State, Iteration]:
    """One iteration with a batch of n ≥ 1 finite samples, of any length (the paper's is 50).

    Raises:
        BadInput: the batch is empty or not finite or lacks a velocity, or the state belongs to another policy or was
            learned over other velocities.

    Example:
        A vehicle whose damping is d(r) = 100 r + 1000 r|r| N m, seen at fifty rates without noise:

        >>> settings = Settings(policy="weighted", gamma=30.0)
        >>> rate = 0.2 * np.sin(0.4 * np.arange(50.0))
        >>> batch = Samples(0.6 * np.arange(50.0), rate, 100.0 * rate + 1000.0 * rate * np.abs(rate))
        >>> state, iteration = step(settings, start(settings), batch)
        >>> iteration.model.predict(np.array([-0.1, 0.1])).damping.round().tolist()
        [-20.0, 20.0]
    """
    batch = _checked(settings, state, batch)
    before, number = state.model, state.iterations + 1
    fastest_others, served = state.memory.fastest, state.memory.served
    alone = by_itself(settings, fastest_others, served, batch, state.memory.noise)
    driven, rate, recent = sift(alone, state.recent)
    at = batch if rate is batch.yaw_rate else replace(batch, yaw_rate=rate)
    samples, place = state.waiting.with_batch(at, driven)
    water, waiting = state.water.after(alone, driven), Waiting()
    learned = before.learned(batch) if before.is_trained else None
    if len(samples) and BATCH_PARTS * len(samples) >= min(settings.batch, len(batch)):
        predicted = learned if samples is batch or learned is None else before.learned(samples)
        policy = _POLICIES[settings.policy]
        memory, iteration = policy.learn(settings, number, state.memory, before, samples, predicted, place)
        noise = memory.noise
        model = iteration.model
        if model is not before:
            model = replace(model, sigma=noise.sigma, correlation=noise.correlation, spread=noise.spread, water=water)
    else:
        memory, model, iteration = state.memory, before, Iteration(number, False, before, served, served)
        waiting = Waiting(samples.time, samples.yaw_rate, samples.damping, place - len(batch), samples.channels)
    iteration = replace(
        iteration,
        model=model,
        time_span=(float(batch.time[0]), float(batch.time[-1])),
        undriven=batch.take(slice(0, 0) if driven.all() else ~driven),
        progressive_mae=None if learned is None else _mean_error(before.served(batch, learned), batch),
    )
    return State(number, model, state.policy, memory, recent, waiting, water), iteration


def _checked(settings: Settings, state: State, batch: Samples) -> Samples:
    """A batch with the channels that damping is learned over, and no further ones.

    Raises:
        BadInput: as `step`.
    """
    if len(batch) == 0:
        raise BadInput("a batch needs at least one sample; wait for more before the next iteration")
    for name, values in (("x", batch.yaw_rate), ("y", batch.damping)):
        if not values.dot(values) < MAX_INPUT_NORM**2:  # NaN compares as false
            if not np.isfinite(values).all():
                raise BadInput("a batch holds NaN or infinite samples; reject them before they reach the learner")
            raise BadInput(
                f"{name} holds values beyond {MAX_INPUT_NORM:g}: reject such samples before they reach the learner"
            )
    if state.policy != settings.policy:
        raise BadInput(f'the state was learned under policy "{state.policy}"; set it or start from an empty state')
    known = state.memory.served.channels
    if set(known) != set(settings.others):
        over = ", ".join(known) or "the own velocity alone"
        raise BadInput(f"the state was learned over {over}; set learner.inputs so or start from an empty state")
    for name in settings.others:
        if name not in batch.channels or not np.isfinite(batch.channels[name]).all():
            raise BadInput(
                f"a batch lacks {name} at some samples, over which damping is learned; leave such samples out"
            )
    return Samples(batch.time, batch.yaw_rate, batch.damping, {name: batch.channels[name] for name in settings.others})


def _mean_error(served: Array, batch: Samples) -> float:
    return float(np.abs(served - batch.damping).sum()) / len(batch)
