"""One iteration of Fig. 3 as a value: state in, batch in → state and `Iteration` out.

    state = start(settings)
    for batch in batches:
        state, iteration = step(settings, state, batch)

There is no clock and no randomness: the same batches give the same models to the bit, also when the state has been
written to a file and read back in between.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.iteration import Iteration, Settings
from incsvr.learning.model import Model
from incsvr.learning.policies import paper, weighted
from incsvr.samples import Samples

__all__ = ["Iteration", "Settings", "State", "start", "step"]

FORM = 1  # of the plain data; a state of another form is refused


@dataclass(frozen=True, slots=True)
class State:
    """All that the learner knows between two iterations; its size is bounded by the settings.

    Attributes:
        iterations: how many have been done.
        model: what is served.
        policy: whose memory it is.
        memory: what the policy carries over.
    """

    iterations: int
    model: Model
    policy: str
    memory: paper.Memory | weighted.Memory

    def to_dict(self) -> dict[str, Any]:
        """Plain data for a file: numbers, strings, lists, dictionaries; exact to the bit through JSON."""
        return {
            "form": FORM,
            "iterations": self.iterations,
            "model": self.model.to_dict(),
            "policy": self.policy,
            "memory": self.memory.to_dict(),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> State:
        if data.get("form") != FORM or data.get("policy") not in _POLICIES:
            raise BadInput("this is not a learner's state of this version; start from an empty state directory")
        policy = data["policy"]
        memory = _POLICIES[policy].Memory.from_dict(data["memory"])
        return State(data["iterations"], Model.from_dict(data["model"]), policy, memory)


_POLICIES = {"paper": paper, "weighted": weighted}


def start(settings: Settings) -> State:
    """The state before the first iteration: nothing learned."""
    model = Model.untrained(settings.gamma, settings.C, settings.epsilon)
    return State(0, model, settings.policy, _POLICIES[settings.policy].start(settings))


def step(settings: Settings, state: State, batch: Samples) -> tuple[State, Iteration]:
    """One iteration with a batch of n ≥ 1 finite samples, of any length (the paper's is 50).

    Raises:
        BadInput: the batch is empty or not finite, or the state belongs to another policy.
    """
    if len(batch) == 0:
        raise BadInput("a batch needs at least one sample; wait for more before the next iteration")
    if not np.isfinite(batch.yaw_rate).all() or not np.isfinite(batch.damping).all():
        raise BadInput("a batch holds NaN or infinite samples; reject them before they reach the learner")
    if state.policy != settings.policy:
        raise BadInput(f'the state was learned under policy "{state.policy}"; set it or start from an empty state')
    batch = Samples(batch.time, batch.yaw_rate, batch.damping)  # the curve knows no further channels
    predicted = state.model.evaluate(batch.yaw_rate) if state.model.is_trained else None
    policy = _POLICIES[settings.policy]
    memory, iteration = policy.learn(settings, state.iterations + 1, state.memory, state.model, batch, predicted)
    return State(iteration.number, iteration.model, state.policy, memory), iteration
