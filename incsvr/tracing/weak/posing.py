"""How the equations are built from recordings: the length of their blocks, the signals on a grid, the noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from incsvr.effects import Signals
from incsvr.errors import BadInput
from incsvr.tracing.run import Array, Run, sample_period
from incsvr.tracing.weak.command import Command, estimated_command
from incsvr.tracing.weak.damping import SPLINE, Damping
from incsvr.tracing.weak.disturbance_response import disturbance_response
from incsvr.tracing.weak.grid import on_fine_grid, settling_time, time_scale
from incsvr.tracing.weak.noise import MOST_GYRO, gyro_noise, jumps, white_noise
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.weak_form import FEWEST_BLOCKS, SUBSTEPS, Blocks, derivative, split
from incsvr.tracing.weak.whitening import Fit, fit

MOST_BLOCKS = 2000
"""Of long recordings: more blocks than that tell no more, so they may be as long as T_c/6."""

WIDER = 1.25
"""Step in which the width of the derivative grows."""

SMEARED = 1.02
"""By how much a wider derivative may differ from a narrower one, in what the gyro's noise alone makes of it."""

SLOWEST = 8.0
"""Times in which the vehicle settles that T_c may last: a command that stays longer tells nothing of the vehicle."""

MOST_OF_IT = 6.0
"""By what T_c is lowered for that at most: the declared inertia may be far off."""

FEWEST_SCALES = 12.0
"""Shortest recordings from which anything is concluded, in T_c."""


def pose(
    runs: Sequence[Run],
    inertia: float,
    channels: Sequence[str],
    *,
    zero_order_hold: bool = False,
    period: float | None = None,
) -> Problem:
    """Set the block length and build the equations.

    T_b starts at T_c/18 and grows until the gyro's noise through the whitening filter, I σ/T_b ‖(1, −a) ∗ (1, −1)‖, is
    at most 0.2 of the innovations' deviation, at most T_c/4.5, or three of the yaw rate's samples where these last
    longer, at most T_c/2 then; or it is `period` [s]. `zero_order_hold` says whether the torque stays at its value
    until its next stamp (a command does) or is linear between them.
    """
    scale = time_scale(runs)
    scale = min(scale, max(SLOWEST * settling_time(runs, inertia), scale / MOST_OF_IT))
    sampled = sample_period(runs, "yaw_rate")
    sigma = gyro_noise(runs)
    _long_enough(runs, scale)
    resolution = _resolution(runs)
    length = sum(float(run.time[-1] - run.time[0]) for run in runs)
    # a loop that swings within a few samples would have a block for each of them, and be traced in half a minute
    longest = max(scale / 4.5, min(3.0 * sampled, scale / 2.0))
    block = min(max(scale / 18.0, 3.0 * resolution, min(length / MOST_BLOCKS, scale / 6.0)), longest)
    block = block if period is None else period
    while True:
        problem = _equations(runs, inertia, channels, scale, block, sampled, zero_order_hold)
        base = fit(problem.y, problem.coarse, problem.blocks, spline=SPLINE)
        noise = _gyro_noise_in(problem, sigma, sampled, base)
        if period is not None:
            break
        # by a step at least: where one sample fills a block, 1.3 of it would be the same again
        longer = max(1.3 * problem.blocks.period, problem.blocks.period + problem.signals.step)
        if noise <= 0.2 * base.scale or longer > longest or len(problem.blocks) / 1.3 < FEWEST_BLOCKS * 1.5:
            break
        block = longer
    problem = _differentiated(problem, sigma, sampled, base.scale)
    problem = replace(problem, feedback=problem.feedback_beside(base.residual))
    noise_fraction, gyro = problem.noise_fraction_beside(base.residual), min((noise / base.scale) ** 2, MOST_GYRO)
    known = problem.knows_command(base.residual)
    problem = replace(
        problem, signals=replace(problem.signals, torque_noise_fraction=noise_fraction, gyro=gyro, known=known)
    )
    return problem.answering(base.theta, base.ar)


def _gyro_noise_in(problem: Problem, sigma: float, period: float, fitted: Fit) -> float:
    """Deviation of what the gyro's noise, `sigma` [rad/s] in samples of `period` seconds, leaves in the innovations."""
    noise = problem.signals.inertia * sigma * np.sqrt(min(period / problem.signals.step, 1.0)) / problem.blocks.period
    return float(noise * np.linalg.norm(np.convolve(np.concatenate([[1.0], -fitted.ar]), [1.0, -1.0])))


def _differentiated(problem: Problem, sigma: float, period: float, innovation: float) -> Problem:
    """The equations with the acceleration; `sigma` [rad/s] is the gyro's noise in samples of `period` seconds."""
    s = problem.signals
    width = _derivative_width(problem, sigma * float(np.sqrt(min(period / s.step, 1.0))), innovation)
    return replace(problem, signals=replace(s, acceleration=derivative(s.rate, s.start, width) / s.step), width=width)


def _derivative_width(problem: Problem, sigma: float, innovation: float) -> float:
    """Of a Gaussian derivative just wide enough that the gyro's noise in I r̈ T_b is 0.3 of the innovations' deviation.

    Narrower, the noise would hide a lag; wider, it would smear the instants at which the command jumps. Where a wider
    one changes the acceleration by no more than the gyro's noise, there is nothing to be smeared, and it is taken.
    """
    s = problem.signals
    # deviation of the derivative of `derivative`, width w samples: σ √(2.135/(√π w⁵)) per step²
    noise = s.inertia * sigma * problem.blocks.period / s.step**2 * np.sqrt(2.135 / np.sqrt(np.pi))
    width = (noise / max(0.3 * innovation, 1e-300)) ** 0.4
    width = float(np.clip(width, 0.9, max(0.6 * problem.blocks.size, 0.9)))  # a narrower one no longer sees a ramp
    unit = np.random.default_rng(0).normal(size=len(s))
    rate, gyro = derivative(s.rate, s.start, width), derivative(unit, s.start, width)
    while (wider := WIDER * width) < 0.1 * s.scale / s.step:
        next_rate, next_gyro = derivative(s.rate, s.start, wider), derivative(unit, s.start, wider)
        if np.std(next_rate - rate) > SMEARED * sigma * np.std(next_gyro - gyro):
            break
        width, rate, gyro = wider, next_rate, next_gyro
    return width


def pose_like(
    problem: Problem, runs: Sequence[Run], tell: Callable[[Signals, Blocks], Command] = estimated_command
) -> Problem:
    """The equations of other runs, with the grid, blocks, damping basis and noise fraction of `problem`; `tell` says
    what their command is."""
    s = problem.signals
    names = ["heading", *s.channels] if _has_heading(runs) else list(s.channels)
    signals = on_fine_grid(runs, s.step, names, problem.zero_order_hold, s.inertia)
    blocks = split(signals.start, problem.blocks.size, s.step, s.scale)
    blocks = replace(blocks, mistimed=jumps(blocks, signals.torque) * problem.resolution / blocks.period)
    acceleration = derivative(signals.rate, signals.start, problem.width) / s.step
    command = tell(signals, blocks)
    signals = replace(
        signals, inertia=s.inertia, scale=s.scale, block=s.block, origin=s.origin, gyro=s.gyro,
        torque_noise_fraction=s.torque_noise_fraction, acceleration=acceleration,
        known=s.known and command.levels is not None,
    )  # fmt: skip
    y = blocks.mean(signals.torque) - s.inertia * blocks.slope(signals.ends)
    like = replace(
        problem, signals=signals, blocks=blocks, y=y, coarse=blocks.mean(problem.damping.columns(signals.rate)),
        steep=_steep(problem.damping, signals.rate, blocks), command=command,
    )  # fmt: skip
    return like.answering(problem.drag, problem.noise_ar)


def _long_enough(runs: Sequence[Run], scale: float) -> None:
    length = sum(float(run.time[-1] - run.time[0]) for run in runs)
    if length < FEWEST_SCALES * scale:
        raise BadInput(
            f"{length:.3g} s are too few to trace anything: the yaw rate changes within {scale:.2g} s, so record at "
            f"least {FEWEST_SCALES * scale:.0f} s of varied turning, better ten minutes"
        )


def _resolution(runs: Sequence[Run]) -> float:
    """Sample period of the slower of the two streams [s]."""
    return max(sample_period(runs, "yaw_rate"), sample_period(runs, "torque"))


def _steep(damping: Damping, rate: Array, blocks: Blocks) -> Array:
    nudge = 1e-3 * float(damping.knots[-1] - damping.knots[0])
    return blocks.mean(damping.columns(rate + nudge) - damping.columns(rate - nudge)) / (2.0 * nudge)


def _equations(
    runs: Sequence[Run],
    inertia: float,
    channels: Sequence[str],
    scale: float,
    block: float,
    period: float,
    zero_order_hold: bool,
) -> Problem:
    step = max(block / SUBSTEPS, period)
    size = max(round(block / step), 1)
    names = ["heading", *channels] if _has_heading(runs) else channels
    signals = on_fine_grid(runs, step, names, zero_order_hold, inertia)
    blocks = split(signals.start, size, step, scale)
    resolution = _resolution(runs)
    blocks = replace(blocks, mistimed=jumps(blocks, signals.torque) * resolution / blocks.period)
    if len(blocks) < FEWEST_BLOCKS:
        raise BadInput(
            f"the recordings hold {len(blocks)} time scales' worth of motion (blocks of {blocks.period:.2g} s), too "
            f"few to trace anything; record at least {FEWEST_BLOCKS * blocks.period:.0f} s of varied turning"
        )
    rate = signals.rate
    y = blocks.mean(signals.torque) - inertia * blocks.slope(signals.ends)
    damping = Damping.over(rate)
    spans = signals.time[signals.start[:-1]], signals.time[signals.start[1:] - 1]
    signals = replace(
        signals, inertia=inertia, scale=scale, block=blocks.period,
        origin=(float(np.min(spans[0])), float(np.max(spans[1]))),
    )  # fmt: skip
    grid = np.linspace(float(np.min(rate)), float(np.max(rate)), 201)
    coarse = blocks.mean(damping.columns(rate))
    table = damping.columns(grid)
    steep = _steep(damping, rate, blocks)
    still = np.zeros(coarse.shape[1])
    white = white_noise(runs) * float(np.sqrt(min(sample_period(runs, "torque") / blocks.period, 1.0)))
    return Problem(
        signals, blocks, y, damping, grid, table, coarse, steep, estimated_command(signals, blocks), resolution,
        zero_order_hold, width=0.0, white=white, drag=still, noise_ar=np.zeros(3),
        disturbance_response=disturbance_response(steep @ still, 0.0, np.zeros(3), 0.0, blocks.period, inertia),
    )  # fmt: skip


def _has_heading(runs: Sequence[Run]) -> bool:
    return all("heading" in run.channels and np.isfinite(run.channels["heading"]).sum() > 10 for run in runs)
