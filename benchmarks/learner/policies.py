"""The two policies of keeping samples, each as it is recommended, and the batches that they are given."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

from incsvr.learning.learner import Settings
from incsvr.signals.samples import Samples
from service.recordings.samples_from_recording import learner_for

Policy = Literal["paper", "weighted"]
POLICIES: tuple[Policy, Policy] = ("paper", "weighted")
GAMMA: dict[Policy, float] = {"paper": Settings().gamma, "weighted": 30.0}
"""[s²/rad²], for a vehicle of ±0.25 rad/s: vectors that stand for many samples bear a narrower kernel."""


def scaled(samples: Samples, policy: Policy) -> Settings:
    """The settings of `incsvr fit` for these samples, with the policy's own kernel width."""
    settings = learner_for(samples, policy=policy)
    return replace(settings, gamma=settings.gamma * GAMMA[policy] / GAMMA["paper"])


def batches(samples: Samples, size: int) -> Iterator[Samples]:
    """Full batches, one after the other; what is left over at the end is none."""
    for first in range(0, len(samples) - size + 1, size):
        yield samples.take(slice(first, first + size))
