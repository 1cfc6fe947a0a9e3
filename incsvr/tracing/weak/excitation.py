"""What these recordings can answer at all: excitation, sign of the torque, and effects that need either."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.effects import Effect
from incsvr.errors import BadInput
from incsvr.tracing.run import Run, stream
from incsvr.tracing.weak.problem import Problem

OF_HEADING = ("heading_current", "tether")
"""What, beside a moment from outside, turns a vehicle whose thrusters do not: the rest only shapes a motion."""

_CONSTANT = (
    "the torque is constant ({:.3g} N m), so nothing can be traced: record a run with varied commands, or add the "
    "channels that turn the vehicle"
)


def demand(problem: Problem, effects: Sequence[Effect]) -> tuple[Effect, ...]:
    """The effects that these recordings can speak about.

    Raises:
        BadInput: the torque never changes and there is no channel to explain the motion; the torque has the wrong sign.
    """
    if constant_torque(problem):
        if not problem.signals.channels:
            raise BadInput(_CONSTANT.format(float(np.mean(problem.signals.torque))))
        return tuple(e for e in effects if e.acts == "outside" or e.name in OF_HEADING)
    _check_sign(problem)
    return tuple(effects)


def constant_torque(problem: Problem) -> bool:
    """Whether the torque never changed to speak of."""
    s = problem.signals
    needed = s.inertia * float(np.std(s.acceleration)) + float(np.std(problem.y))
    return float(np.std(s.torque)) <= 1e-6 * max(needed, 1e-12)


def answered(problem: Problem, verdict: str, runs: Sequence[Run]) -> None:
    """Refuse to say that nothing is missing where the torque never put the model to the test.

    Raises:
        BadInput: the verdict is `none`, and the torque is constant or does not move the vehicle.
    """
    if verdict != "none":
        return
    mean, spread = float(np.mean(problem.signals.torque)), float(np.std(problem.signals.torque))
    if constant_torque(problem):
        raise BadInput(
            f"the torque is constant ({mean:.3g} N m) and no channel explains the motion on data that it was not "
            "fitted to: record a run with varied commands"
        )
    if only_noise(runs) and _followed(problem) < FOLLOWED:
        raise BadInput(
            f"the torque ({mean:.3g} ± {spread:.2g} N m) does not move the vehicle: the yaw rate holds nothing but the "
            "gyro's noise; record a run with varied commands that turn it"
        )


NOISE = 0.8
"""Half the mean square of the yaw rate's differences, in its variance, from which it is white: 1 of noise, at most
0.04 of any motion seen."""

FOLLOWED = 0.1
"""Part of the torque's variance in which a torque that moves the vehicle is seen, however little."""


def only_noise(runs: Sequence[Run]) -> bool:
    """Whether the yaw rate keeps one value in all runs but for what differs from sample to sample."""
    rates = [stream(run, run.yaw_rate)[1] for run in runs]
    leaps = np.concatenate([np.diff(rate) for rate in rates])
    return 0.5 * float(np.mean(leaps**2)) > NOISE * float(np.var(np.concatenate(rates)))


def _followed(problem: Problem) -> float:
    """Part of the torque's variance that acceleration and drag explain."""
    blocks, s = problem.blocks, problem.signals
    torque = blocks.mean(s.torque)
    motion = (blocks.slope(s.ends), blocks.mean(s.rate), blocks.mean(s.rate * np.abs(s.rate)), np.ones(torque.size))
    design = np.column_stack(motion)
    left = torque - design @ np.linalg.lstsq(design, torque, rcond=None)[0]
    return 1.0 - float(np.var(left)) / max(float(np.var(torque)), 1e-300)


def _check_sign(problem: Problem) -> None:
    """τ ≈ a ṙ + b r with a and b both clearly negative means that torque and yaw rate count in opposite directions."""
    torque = problem.blocks.mean(problem.signals.torque)
    design = np.column_stack([problem.blocks.slope(problem.signals.ends), problem.blocks.mean(problem.signals.rate)])
    theta, *_ = np.linalg.lstsq(design, torque, rcond=None)
    residual = torque - design @ theta
    explained = 1.0 - float(residual @ residual) / max(float(torque @ torque), 1e-300)
    if explained > 0.3 and theta[0] < 0.0 and theta[1] < 0.0:
        raise BadInput(
            "torque and yaw rate count in opposite directions (the vehicle turns against its thrust): multiply torque "
            "by −1, it must be positive the way yaw_rate is"
        )
