"""The demo's third act: Leng with its hull goes on, and under way something breaks that nobody is told of.

A seed draws what comes on (one of EFFECTS, of realistic size), when, and how the vehicle is driven. The streams hold
yaw rate and torque alone: the torque as the rotors' told speeds make it in a vehicle that is sound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from service.recordings.recording import Recording
from simulator.physics import Physics, Truth
from simulator.steered import MAX_TORQUE, at_sea, steps_and_sines

EFFECTS = ("dead_zone", "torque_asymmetry", "torque_saturation", "bias_torque", "inertia")
"""What may come on: thrusters that turn at large commands only, or give less astern or at full command; a fin that
bends; a payload. Not thrusters that begin to lag: the checks of the streams take that for a clock that jumped."""
DURATION = 800.0
"""[s]"""
SOUND = (60.0, 90.0)
"""For so long all is as it was [s]; the seed draws."""


@dataclass(frozen=True, slots=True)
class Underway:
    """The third act as it was played.

    Attributes:
        recording: yaw rate [rad/s] and torque [N m].
        effect: the name of what came on.
        onset: when, on the recording's clock [s].
        truth: its parameters.
        thrust: commands at rest, each with the moment that acts [N m]; empty of an effect beside the thrusters.
    """

    recording: Recording
    effect: str
    onset: float
    truth: Truth
    thrust: tuple[tuple[float, float], ...]


def play(seed: int) -> Underway:
    """The third act that a seed draws."""
    random = np.random.default_rng([seed, *b"underway"])
    effect, onset = str(random.choice(EFFECTS)), float(round(random.uniform(*SOUND)))
    told = steps_and_sines(DURATION, random)
    recording, outcome = at_sea("T3", told, seed, hidden=(effect,), onset=onset, hull=True)
    return Underway(recording, effect, onset, outcome.truth[effect], _thrust(outcome.hidden))


def _thrust(hidden: Physics) -> tuple[tuple[float, float], ...]:
    """Commands up to half above the highest, each with the moment that acts at rest [N m]."""
    if not hidden.stages:
        return ()
    pairs = []
    for asked in (np.linspace(-1.5, 1.5, 31) * MAX_TORQUE).tolist():
        moment = asked
        for stage in hidden.stages:
            moment = stage(moment)(moment)
        pairs.append((asked, moment))
    return tuple(pairs)
