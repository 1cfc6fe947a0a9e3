"""The two policies of keeping samples, each as it is recommended."""

from __future__ import annotations

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
