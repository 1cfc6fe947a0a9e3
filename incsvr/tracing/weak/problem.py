"""What the tracer solves: the block equations of all runs, their damping basis and the torque's noise fraction."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from incsvr.effects import Signals
from incsvr.tracing.run import Array
from incsvr.tracing.weak.command import Command, is_noise
from incsvr.tracing.weak.damping import Damping
from incsvr.tracing.weak.disturbance_response import DisturbanceResponse, disturbance_response
from incsvr.tracing.weak.feedback import controller_gain
from incsvr.tracing.weak.noise import noise_fraction
from incsvr.tracing.weak.weak_form import Blocks
from incsvr.tracing.weak.whitening import Fit


@dataclass(frozen=True, slots=True)
class Problem:
    """Block equations y = mean(d(r)) + Σ θ mean(φ) + u over all runs.

    Attributes:
        signals: on the fine grid; `acceleration` is the derivative of the rate, as little smoothed as the gyro allows.
        blocks: the blocks.
        y: (n_b,) mean(τ) − I₀ Δr/T_b [N m].
        damping: the basis of d(r); `coarse` (n_b, 11) its columns, `grid` (201,) and `grid_columns` a table of it.
        steep: (n_b, 11) derivative of `coarse` by the rate.
        resolution: [s] sample period of the slower of the two streams: no delay below it can be told from the sampling.
        zero_order_hold: whether the torque is taken as held between its stamps (else as linear).
        width: of the Gaussian derivative that gives ṙ [fine steps].
        white: deviation of the torque's white noise in a block [N m].
        feedback: K, by which the torque goes against the yaw rate, 0 in open loop [N m s/rad].
        drag: (11,) coefficients of the damping, by which the rate's answer to noise fades.
        noise_ar: (3,) AR of that noise.
        disturbance_response: that answer.
        command: what is known of it beside the torque's noise.
    """

    signals: Signals
    blocks: Blocks
    y: Array
    damping: Damping
    grid: Array
    grid_columns: Array
    coarse: Array
    steep: Array
    command: Command
    resolution: float
    zero_order_hold: bool
    width: float
    white: float
    drag: Array
    noise_ar: Array
    disturbance_response: DisturbanceResponse
    feedback: float = 0.0

    @property
    def closed_loop(self) -> bool:
        """Whether the torque is feedback of the yaw rate."""
        return self.feedback > 0.0

    @property
    def one_sine(self) -> bool:
        """Whether nearly all of the command's variance lies in one line of its spectrum."""
        in_line = total = 0.0
        for run in self.signals.runs():
            torque = self.signals.torque[run]
            power = np.abs(np.fft.rfft((torque - torque.mean()) * np.hanning(torque.size))) ** 2
            peak = int(np.argmax(power))
            in_line += float(power[max(peak - 2, 0) : peak + 3].sum())
            total += float(power.sum())
        return in_line > 0.9 * total

    def knows_command(self, residual: Array) -> bool:
        """Whether the torque is levels, noise and no controller's answer, as a residual (n_b,) tells."""
        if self.command.levels is None or self.closed_loop:
            return False
        return is_noise(self.blocks, self.blocks.mean(self.signals.torque - self.command.levels), residual)

    def noisy(self, fitted: Fit) -> Array:
        """(64,) the torque's white noise in parts of the residual's spectrum, from zero to π/T_b [rad/s]."""
        shift = np.exp(-1j * np.pi * (np.arange(64) + 0.5) / 64.0)
        inverse_spectrum = np.abs(1.0 - fitted.ar[0] * shift - fitted.ar[1] * shift**2 - fitted.ar[2] * shift**3) ** 2
        part: Array = self.white**2 * inverse_spectrum / fitted.scale**2
        return part

    @property
    def jacobian(self) -> Array:
        """(2, n_b, 11) how the damping's columns answer the noise of their own block, for `whitening.fit`.

        A disturbance turns the vehicle within the block in which it acts: see `disturbance_response`.
        """
        jacobian: Array = self.signals.turning * self.disturbance_response.mean[:, None] * self.steep
        return np.stack([jacobian, np.zeros_like(jacobian)])

    def answering(self, drag: Array, noise_ar: Array) -> Problem:
        """The equations with the rate's answer to noise of this colour beside this damping."""
        s, slope = self.signals, np.maximum(self.steep @ drag, 0.0)
        response = disturbance_response(
            slope, self.feedback, noise_ar, s.torque_noise_fraction, self.blocks.period, s.inertia
        )
        return replace(self, drag=drag, noise_ar=noise_ar, disturbance_response=response)

    def feedback_beside(self, residual: Array) -> float:
        """K [N m s/rad] of a controller, as a residual (n_b,) and the streams tell; 0 in open loop."""
        s = self.signals
        return controller_gain(self.blocks, s.torque, s.rate, residual, s.inertia)

    def noise_fraction_beside(self, residual: Array, gyro: Array | None = None) -> float:
        """Part of the noise that sits in the torque, as a residual (n_b,) and what the gyro does to it tell; as it was
        where they do not."""
        torque, rate = self.signals.torque, self.signals.rate
        read = noise_fraction(self.blocks, torque, residual, gyro, -self.feedback * self.blocks.mean(rate))
        return self.signals.torque_noise_fraction if read is None else read
