"""Free runs of a served model side by side, with what makes them uncertain: the water, and the doubt of the curve.

    I ṙ = τ − d(r) − Σ effects + w,  ψ̇ = r,  w a first-order Gauss–Markov process

The engine simulates the mean. The covariance follows the slopes along it, as in the engine's tangent.

Source: A. Gelb (ed.), Applied Optimal Estimation, 1974, ch. 3.8 (shaping filters).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from incsvr.compensation.effects_in_force import Compensation
from incsvr.forecasting.grid import Grid
from incsvr.forecasting.learned_motion import LINEAR, OUTSIDE, LearnedDamping, simulated
from incsvr.learning.model import Model
from incsvr.model.factors import Indices, one_by_one, slopes
from incsvr.model.series import effort_of
from incsvr.model.simulation import Course
from incsvr.numerics import Array
from incsvr.plant.axes import YAW

MIN_CORRELATION = 0.05
"""Correlation of the noise of two samples, at least: less cannot be told from none, and would be a time of nearly
nothing."""


@dataclass(frozen=True, slots=True)
class Runs:
    """Free runs at the ends of their steps, the start first.

    Attributes:
        rate, heading: (steps + 1, n) [rad/s], [rad] turned since the start.
        rate_sigma, heading_sigma: (steps + 1, n) one standard deviation.
    """

    rate: Array
    heading: Array
    rate_sigma: Array
    heading_sigma: Array


@dataclass(frozen=True, slots=True)
class Water:
    """What pushes a vehicle beside its torque: one standard deviation [N m], and its correlation time [s]."""

    disturbance: float
    lasts: float

    @staticmethod
    def of(model: Model, period: float) -> Water:
        """The water in a model's samples, which come every `period` [s]."""
        return Water(float(model.sigma), -period / math.log(min(max(model.correlation, MIN_CORRELATION), 0.999)))


def free_runs(
    model: Model,
    inertia: float,
    fastest: float,
    grid: Grid,
    first: Indices,
    steps: int,
    rate: Array,
    rate_sigma: float,
    effects: Compensation | None = None,
) -> Runs:
    """n runs of a trained model, side by side; one that the grid ends stays where it is then.

    Args:
        inertia: as it is declared [kg m²].
        fastest: the fastest rate of the vehicle [rad/s].
        grid: without a pause; it holds the model's further velocities, and what effects remember.
        first: (n,) the points of the grid at which they start.
        steps: of the longest.
        rate: (n,) where they start [rad/s].
        rate_sigma: how well that is known [rad/s].
        effects: traced effects in force; None for none.
    """
    along = slice(int(first.min()), int(first.max()) + steps + 1)
    names = () if model.several is None else model.several.others
    others = np.array([grid.beside.channels[name][along] for name in names]).T
    damping = LearnedDamping.of(model, fastest, grid.time[along], others)
    return propagate(
        damping, Water.of(model, grid.sample_period), inertia, grid, first, steps, rate, rate_sigma, effects
    )


def propagate(
    damping: LearnedDamping,
    water: Water,
    inertia: float,
    grid: Grid,
    first: Indices,
    steps: int,
    rate: Array,
    rate_sigma: float,
    effects: Compensation | None = None,
) -> Runs:
    """As `free_runs`, of a damping in this water."""
    model = None if effects is None else effects.model
    axis, step, beside = YAW.rate if model is None else model.axis, grid.step, grid.beside
    parts = max(math.ceil(step / damping.time_constant(inertia)), 1)  # of a step, so that no velocity decays within one
    edges = grid.time[0] + step / parts * np.arange((grid.time.size - 1) * parts + 1)
    run = {axis: (edges, np.interp(edges, grid.time, grid.rate)), effort_of(axis): (grid.time, grid.torque)}
    for name, stream in () if effects is None else effects.streams.items():
        if name != axis:
            run[name] = grid.time, beside.channels[stream]
    for name, taken in ((OUTSIDE, beside.outside), (LINEAR, beside.linear)):
        if taken is not None:
            run[name] = grid.time, taken
    course = simulated(damping, inertia, run, step / parts, parts * first, parts * steps, rate, model)
    r, whole = course.states[::parts, 0], course.motion.structure.inertia({}, axis)
    heading = np.concatenate((np.zeros((1, rate.size)), np.cumsum(0.5 * step * (r[1:] + r[:-1]), axis=0)))
    # A free run gains no energy: where a curve drives, by its own doubt, it is flat.
    slope = np.maximum(_slopes(course)[::parts], 0.0)
    decay = np.exp(-slope * step / whole)
    gain = np.where(slope != 0.0, (1.0 - decay) / np.where(slope == 0.0, 1.0, slope), step / whole)
    off = gain * damping.doubt_at(edges[course.motion.windows.at[:-1:parts]], r[:-1])
    return Runs(r, heading, *_deviations(water, decay, gain, off, step, rate_sigma))


def _slopes(course: Course) -> Array:
    """(steps, n) by how much the moment that drives falls with the velocity, at the beginning of each step [N m s]."""
    motion = course.motion
    (axis,) = motion.structure.axes
    signals = {name: course.states[:-1, k] for k, name in enumerate(motion.states)}
    signals |= {name: motion.edges[:-1, k] for k, name in enumerate(motion.channels)}
    signals[effort_of(axis)] = motion.efforts[:, 0, 0]
    found = np.zeros_like(signals[axis])
    for row in motion.structure.rows:
        part, coefficient = row.parts[0], motion.value[row.key][0]
        for factor, beside in ((part.one, part.other), (part.other, part.one)):
            for number, slope, of in slopes(factor):
                if of == axis:
                    taken = one_by_one(slope, signals) * one_by_one(beside, signals)
                    found += number * part.sign * coefficient * taken
    return found


def _deviations(
    water: Water, decay: Array, gain: Array, off: Array, step: float, rate_sigma: float
) -> tuple[Array, Array]:
    """(steps + 1, n) each: one standard deviation of rate and heading, of the covariance of (r, ψ, w, c).

    The doubt of the curve is no noise: it is off to one side for long, so that it is a state c that stays, of deviation
    one.

    Args:
        decay: (steps, n) what is left of a rate after a step.
        gain: (steps, n) what a moment within makes of it [rad/s for each N m].
        off: (steps, n) what one deviation of the curve makes of it [rad/s].
    """
    steps, count = decay.shape
    stays, variance = math.exp(-step / water.lasts), water.disturbance**2
    after = np.zeros((steps, count, 4, 4))
    after[..., 0, 0], after[..., 0, 2], after[..., 0, 3] = decay, gain, off
    after[..., 1, :] = 0.5 * step * after[..., 0, :]  # a heading follows the mean of both rates
    after[..., 1, 0] += 0.5 * step
    after[..., 1, 1], after[..., 2, 2], after[..., 3, 3] = 1.0, stays, 1.0
    now, fresh = np.diag([rate_sigma**2, 0.0, variance, 1.0]), np.diag([0.0, 0.0, variance * (1.0 - stays**2), 0.0])
    now, found = np.repeat(now[None], count, axis=0), np.empty((steps + 1, count, 2))
    for k in range(steps):
        found[k] = now[:, (0, 1), (0, 1)]
        now = after[k] @ now @ after[k].swapaxes(1, 2) + fresh
    found[steps] = now[:, (0, 1), (0, 1)]
    rate, heading = np.sqrt(np.maximum(found, 0.0)).transpose(2, 0, 1)
    return rate, heading
