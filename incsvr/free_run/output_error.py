"""The moment of inertia identified together with the damping, where nobody declared it (output error).

The free run I ṙ = τ − b − N_r r − N_rr r|r| − N_rrr r³, from the first measured yaw rate of each run, is brought as
close as possible to the measured yaw rate, over I, the damping's coefficients and a constant moment b. The measured
rate enters as what is to be met only, never as a regressor: the gyro's noise, which drags the inertia of every
regression on a differentiated rate towards zero (errors in variables), does not bias this one. The loss is soft beyond
three standard deviations, for spikes.

Its limits, to be said with the figure: it takes the torque for true, so a thrust gain of g appears as I/g, and a lag or
a delay of the thrusters as inertia; it takes the torque for independent of disturbances, so it belongs to open-loop
runs; and where the vehicle hardly accelerates the data say little about I, which the standard error then shows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from incsvr.errors import BadInput
from incsvr.free_run.integrator import free_run
from incsvr.free_run.motions import Motion
from incsvr.numerics import Array, robust_deviation, root_mean_square
from incsvr.plant.words import YAW_WORDS, AxisWords

_SCORE_BLOCKS = 20
"""Blocks of time between which the scores scatter."""


@dataclass(frozen=True, slots=True)
class InertiaEstimate:
    """The inertia by output error, with its deviation.

    Attributes:
        inertia: I [kg m²].
        standard_error: of I [kg m²], from the scatter of the scores between twenty blocks of time, so that it holds for
            residuals with a memory; it knows nothing of the limits above.
        rmse: of the free run on the runs it was fitted to [rad/s].
    """

    inertia: float
    standard_error: float
    rmse: float


def identify(
    runs: Sequence[Motion], advance: Callable[[], None] = lambda: None, words: AxisWords = YAW_WORDS
) -> InertiaEstimate:
    """Identifies I together with the damping.

    Args:
        runs: at least one run in which the torque and the yaw rate change.
        advance: called after every simulation of all runs.
        words: what messages call the quantities of the axis.

    Raises:
        BadInput: where the runs cannot tell the inertia.
    """
    rates = np.concatenate([run.yaw_rate for run in runs]) if runs else np.empty(0)
    torques = np.concatenate([run.torque for run in runs]) if runs else np.empty(0)
    if rates.size < 100 or np.ptp(rates) == 0.0 or np.ptp(torques) == 0.0:
        streams = f"{words.effort} and {words.rate}"
        raise BadInput(f"the {words.inertia} cannot be estimated: {streams} must change, over at least 100 samples")
    # In units of the largest rate and torque the damping's coefficients are of the order of one.
    rate_scale, torque_scale = float(np.abs(rates).max()), float(np.abs(torques).max())

    def residual(unknown: Array) -> Array:
        advance()
        inertia = float(np.exp(unknown[0]))
        linear, quadratic, cubic, constant = map(float, unknown[1:] * torque_scale)
        linear, quadratic, cubic = linear / rate_scale, quadratic / rate_scale**2, cubic / rate_scale**3

        def drag(rate: float) -> float:
            return constant + rate * (linear + abs(rate) * (quadratic + cubic * abs(rate)))

        errors = [run.error(lambda t, tau, r0: free_run(t, tau, r0, inertia=inertia, damping=drag)) for run in runs]
        return np.nan_to_num(np.concatenate(errors) / rate_scale, nan=1e3)

    start = _start(runs, rate_scale, torque_scale)
    rough = least_squares(residual, start, x_scale=0.1, max_nfev=30)
    soft = 3.0 * max(1e-6, robust_deviation(rough.fun))
    fit = least_squares(residual, rough.x, x_scale=0.1, loss="soft_l1", f_scale=soft, max_nfev=30)
    relative = _relative_error(np.asarray(fit.jac), fit.fun, soft)
    rmse = root_mean_square(fit.fun) * rate_scale
    if not (rmse < 0.9 * float(np.std(rates)) and relative < 0.5):
        raise BadInput(
            f"the {words.inertia} cannot be estimated: no free run follows these recordings; give open-loop runs in "
            f"which the vehicle speeds up and slows down, or declare the {words.inertia}"
        )
    inertia = float(np.exp(fit.x[0]))
    return InertiaEstimate(inertia, inertia * relative, rmse)


def _start(runs: Sequence[Motion], rate_scale: float, torque_scale: float) -> Array:
    """Least squares in blocks: mean τ = I Δr/T + mean of the damping's terms. Biased, but near enough to start from."""
    rows, targets = [], []
    for run in runs:
        torque = np.interp(run.rate_time, run.torque_time, run.torque)
        length = max(2, run.rate_time.size // max(20, int(np.ptp(run.rate_time) / 2.0)))
        for k in range(0, run.rate_time.size - length, length):
            part = slice(k, k + length + 1)
            rate, size = run.yaw_rate[part] / rate_scale, np.abs(run.yaw_rate[part]) / rate_scale
            rise = (rate[-1] - rate[0]) / np.ptp(run.rate_time[part])
            rows.append((rise, rate.mean(), (rate * size).mean(), (rate * size * size).mean(), 1.0))
            targets.append(torque[part].mean() / torque_scale)
    solution = np.linalg.lstsq(np.array(rows), np.array(targets))[0]
    inertia = max(float(solution[0]), 1e-3) * torque_scale / rate_scale
    return np.concatenate(([np.log(inertia)], solution[1:]))


def _relative_error(jacobian: Array, residual: Array, soft: float) -> float:
    """Standard error of ln I by the sandwich formula, scores summed over blocks of time."""
    # least_squares scales its Jacobian for the soft loss by (1 + z)^(-3/4); a score's own factor is (1 + z)^(-1/2).
    scores = jacobian * (residual * (1.0 + (residual / soft) ** 2) ** 0.25)[:, None]
    starts = np.linspace(0, residual.size, _SCORE_BLOCKS, endpoint=False).astype(int)
    sums = np.add.reduceat(scores, starts, axis=0)
    information = jacobian.T @ jacobian
    if np.linalg.cond(information) > 1e12:
        return np.inf
    bread = np.linalg.inv(information)
    covariance = bread @ (sums.T @ sums) @ bread * (_SCORE_BLOCKS / (_SCORE_BLOCKS - 1.0))
    return float(np.sqrt(covariance[0, 0]))
