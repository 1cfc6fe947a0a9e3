"""Free runs of a learned model: the velocity that follows from the torque alone, beside the one that was measured.

The step is of Runge and Kutta, fourth order. Other velocities that the damping goes by are as they were measured.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from incsvr.compensation.effects_in_force import Compensation
from incsvr.forecasting.learned_motion import LearnedDamping, simulated
from incsvr.learning.model import Model
from incsvr.model.series import effort_of, together, without_pauses
from incsvr.numerics import Array, Streams, root_mean_square
from incsvr.plant.body import Coupled
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.signals.coupled import motion_at
from incsvr.signals.samples import Samples

Damping = Callable[[float, float], float]
"""d(r, t): a yaw rate [rad/s], and the instant [s] → the damping moment [N m]."""
MAX_STEP_S = 0.05
"""Longest step [s]: a vehicle under water hardly settles within one."""
RUNAWAY_RATES = 1e3
"""A run has run away beyond so many times its first rate, or one [rad/s] where that is slower."""
MIN_MOTION_S = 1.0
"""Length of a motion [s] below which it shows nothing of a vehicle."""


@dataclass(frozen=True, slots=True)
class Motion:
    """One stretch of time without a gap in either stream.

    Attributes:
        torque_time: (n,) stamps of the torque [s], strictly increasing.
        torque: (n,) [N m]; before its first stamp its first value is taken.
        rate_time: (m,) stamps of the yaw rate [s], strictly increasing, none after the torque ends.
        yaw_rate: (m,) [rad/s].
        linear: (n,) what other velocities make of the own one at the torque's stamps [N m s]; None for nothing.
    """

    torque_time: Array
    torque: Array
    rate_time: Array
    yaw_rate: Array
    linear: Array | None = None

    def among(self, coupled: Coupled, streams: Streams, smoothing: float) -> Motion:
        """The motion with what the body's other velocities and its attitude take, through a filter this wide [s]."""
        motion, angles = motion_at(coupled, streams, self.torque_time, smoothing)
        outside, linear = coupled.driving(motion, angles, self.torque_time.size)
        return replace(self, torque=self.torque - outside, linear=linear)


@dataclass(frozen=True, slots=True)
class FreeRun:
    """A motion simulated from its first measured yaw rate, beside what was measured.

    Attributes:
        time: (m,) stamps [s].
        measured, simulated: (m,) yaw rates [rad/s]; simulated is NaN from where the model runs away.
    """

    time: Array
    measured: Array
    simulated: Array

    @property
    def error(self) -> Array:
        """(m,) [rad/s]."""
        return self.simulated - self.measured


@dataclass(frozen=True, slots=True)
class FreeRunErrors:
    """Root mean square errors over free runs [rad/s]: of the model (None where it runs away), of no motion at all, and
    of the first rate kept."""

    model: float | None
    zero: float
    hold: float

    @staticmethod
    def of(runs: Sequence[FreeRun]) -> FreeRunErrors:
        zero = [run.measured for run in runs] or [np.zeros(1)]
        hold = [run.measured - run.measured[0] for run in runs] or [np.zeros(1)]
        return FreeRunErrors(rmse(runs), root_mean_square(np.concatenate(zero)), root_mean_square(np.concatenate(hold)))


@dataclass(frozen=True, slots=True)
class FitPictures:
    """What a report of a fit draws: a learned curve with what it was learned from and what it is judged by."""

    model: Model  # the final one
    samples: Samples  # all that the recordings gave
    free_runs: list[FreeRun]  # of the model, each of a stretch without a gap
    where: str  # the recordings that these are of
    unseen: bool  # whether these were not learned from


def motions(streams: Streams, gap: float) -> list[Motion]:
    """The stretches of a recording in which neither stream pauses for longer than `gap` [s]."""
    both = {name: streams[name] for name in (TORQUE, YAW_RATE)}
    if any(time.size < 2 for time, _ in both.values()):
        return []
    parts = (together(part) for part in without_pauses(both, tuple(both), 0.0, gap))
    found = [Motion(*part[TORQUE], *part[YAW_RATE]) for part in parts]
    return [motion for motion in found if motion.rate_time.size and np.ptp(motion.rate_time) >= MIN_MOTION_S]


def free_runs(pieces: Sequence[tuple[Motion, Streams]], inertia: float, model: Model) -> list[FreeRun]:
    """The free run of each motion, given with the streams of its recording, under a learned model with I [kg m²]."""
    fastest = max((float(np.abs(motion.yaw_rate).max()) for motion, _ in pieces), default=0.0)
    if model.several is None:
        curve = tabulated(lambda rates: model.predict(rates).damping, 2.0 * max(fastest, 1e-3))
        return [_free_run(motion, inertia, curve) for motion, _ in pieces]
    return [_free_run(motion, inertia, _beside(model, streams)) for motion, streams in pieces]


def traced_free_runs(
    pieces: Sequence[tuple[Motion, Streams]],
    damping: Callable[[Array], Array],
    effects: Compensation,
    steps: float = 40.0,  # in the vehicle's time scale
) -> list[FreeRun]:
    """The free run of each motion under a learned curve and traced effects, on the engine.

    Args:
        damping: d(r), (n,) rad/s → (n,) N m.
        effects: those that the curve was freed of; the streams of a recording hold what they read.
    """
    model, found = effects.model, list[FreeRun]()
    fastest = max((float(np.abs(motion.yaw_rate).max()) for motion, _ in pieces), default=0.0)
    curve, step = LearnedDamping.curve(damping, max(fastest, 1e-3)), model.scale / steps
    for motion, streams in pieces:
        time, rate = motion.rate_time, motion.yaw_rate
        edges = time[0] + step * np.arange(max(ceil((time[-1] - time[0]) / step - 1e-9), 1) + 1)
        run = {name: streams[stream] for name, stream in effects.streams.items()}
        run |= {model.axis: (edges, np.interp(edges, time, rate))}
        run[effort_of(model.axis)] = motion.torque_time, motion.torque
        first = np.zeros(1, dtype=np.intp)
        course = simulated(curve, model.inertia, run, step, first, edges.size - 1, rate[:1], model)
        found.append(FreeRun(time, rate, np.interp(time, edges, course.states[:, 0, 0])))
    return found


def rmse(runs: Sequence[FreeRun]) -> float | None:
    """The root mean square error of free runs [rad/s]; None where there is none, or one runs away."""
    value = root_mean_square(np.concatenate([run.error for run in runs])) if runs else np.nan
    return value if np.isfinite(value) else None


def free_run(
    time: Array, torque: Array, yaw_rate: float, *, inertia: float, damping: Damping, linear: Array | None = None
) -> Array:
    """The yaw rate simulated from the torque alone, I ṙ = τ − d(r, t) − b r, (n,) [rad/s].

    A simulation that runs away, because the damping feeds energy in, is NaN from there on.

    Args:
        time: (n,) stamps [s], strictly increasing.
        torque: (n,) τ [N m], linear between the stamps.
        yaw_rate: the first yaw rate [rad/s].
        inertia: I [kg m²].
        damping: d(r, t).
        linear: (n,) b [N m s], what other velocities make of the own one, linear between the stamps; None for none.
    """
    result = np.full(time.size, np.nan)
    if time.size == 0:
        return result
    rate = result[0] = float(yaw_rate)
    bound = RUNAWAY_RATES * max(1.0, abs(rate))
    stamps, moments = time.tolist(), torque.tolist()
    slopes = [0.0] * time.size if linear is None else linear.tolist()
    for k in range(1, time.size):
        whole = stamps[k] - stamps[k - 1]
        count = max(1, ceil(whole / MAX_STEP_S - 1e-9))
        step, rise = whole / count, (moments[k] - moments[k - 1]) / count
        steeper = (slopes[k] - slopes[k - 1]) / count
        for part in range(count):
            at, before, first = (
                stamps[k - 1] + part * step,
                moments[k - 1] + part * rise,
                slopes[k - 1] + part * steeper,
            )
            middle, half, end = before + 0.5 * rise, first + 0.5 * steeper, first + steeper
            k1 = (before - damping(rate, at) - first * rate) / inertia
            second = rate + 0.5 * step * k1
            k2 = (middle - damping(second, at + 0.5 * step) - half * second) / inertia
            third = rate + 0.5 * step * k2
            k3 = (middle - damping(third, at + 0.5 * step) - half * third) / inertia
            fourth = rate + step * k3
            k4 = (before + rise - damping(fourth, at + step) - end * fourth) / inertia
            rate += step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        if not abs(rate) < bound:
            break
        result[k] = rate
    return result


def tabulated(damping: Callable[[Array], Array], limit: float, nodes: int = 4001) -> Damping:
    """d(r) of one number for `free_run`, linear between `nodes` rates within ±limit [rad/s], asked itself beyond.

    With R = limit it is off by at most (R/(nodes − 1))² max|d″|/2: 8e-5 N m for R = 0.5 rad/s and a d″ of 10⁴ N m s².
    """
    rates = np.linspace(-limit, limit, nodes)
    values: list[float] = damping(rates).tolist()
    scale = (nodes - 1) / (2.0 * limit)

    def drag(rate: float, _: float = 0.0) -> float:
        place = (rate + limit) * scale
        if not 0.0 <= place < nodes - 1:
            return float(damping(np.array([rate]))[0])
        cell = int(place)
        return values[cell] + (place - cell) * (values[cell + 1] - values[cell])

    return drag


def _beside(model: Model, streams: Streams) -> Damping:
    """The damping of a model over several velocities, the others as they were measured."""
    several = model.several
    assert several is not None

    def drag(rate: float, at: float) -> float:
        velocity = np.array([[rate, *(np.interp(at, *streams[name]) for name in several.others)]])
        return float(several.value(velocity, model.gamma, model.weight)[0])

    return drag


def _free_run(motion: Motion, inertia: float, damping: Damping) -> FreeRun:
    begin = motion.rate_time[0]
    time = np.concatenate(([begin], motion.torque_time[motion.torque_time > begin]))
    torque = np.interp(time, motion.torque_time, motion.torque)
    linear = None if motion.linear is None else np.interp(time, motion.torque_time, motion.linear)
    simulated = free_run(time, torque, float(motion.yaw_rate[0]), inertia=inertia, damping=damping, linear=linear)
    return FreeRun(motion.rate_time, motion.yaw_rate, np.interp(motion.rate_time, time, simulated))
