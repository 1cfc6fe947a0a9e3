"""A periodic moment."""

from __future__ import annotations

import math

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals


class Wave(Effect):
    """A sin(2π t/P + φ), t from the start of the fitted recordings."""

    name = "wave"
    sentence = "a periodic moment acts that depends on time alone, as of regular waves"
    source = "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 8 (wave moments)"
    acts = "outside"
    core = 2
    searched = True
    looks = 300.0
    needs_clock = True

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        """Periods at the highest peaks of the residual's spectrum, as it is and differenced."""
        hop = max(round(s.block / s.step), 1)
        spectrum, size = np.zeros(0), 1 << (4 * max(run.stop - run.start for run in s.runs()) // hop).bit_length()
        frequency = np.fft.rfftfreq(size, hop * s.step)
        tone = np.zeros(frequency.size, complex)
        for run in s.runs():
            values = s.residual[run][::hop]
            shift = np.exp(-2j * np.pi * frequency * (s.time[run][0] - s.origin[0]))
            tone += shift * np.fft.rfft(values - np.mean(values), size)
        spectrum = np.abs(tone)
        low, high = self.bounds(s)
        allowed = (frequency > 1.0 / high) & (frequency < 1.0 / low)
        periods: list[tuple[float, ...]] = []
        for weight in (np.ones_like(frequency), np.abs(np.sin(np.pi * np.minimum(frequency * hop * s.step, 0.5)))):
            power = np.where(allowed, spectrum * weight, 0.0)
            for _ in range(3):
                k = int(np.argmax(power))
                if power[k] <= 0.0:
                    break
                periods.append((1.0 / float(frequency[k]),))
                power[max(k - 8, 0) : k + 9] = 0.0
        return periods

    def bounds(self, s: Signals) -> tuple[float, float]:
        length = max(float(s.time[run][-1] - s.time[run][0]) for run in s.runs())
        return 2.5 * s.block, max(length / 4.0, 5.0 * s.block)

    def bracket(self, s: Signals, inner: tuple[float, ...]) -> tuple[float, float]:
        half = 0.6 * inner[-1] ** 2 / (s.origin[1] - s.origin[0])  # about the width of the spectrum's peak
        low, high = self.bounds(s)
        return max(inner[-1] - half, low), min(inner[-1] + half, high)

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        phase = 2.0 * np.pi / inner[-1] * (s.time - s.origin[0])
        return stack(-np.sin(phase), -np.cos(phase))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        sine, cosine = term.coefficients
        return {
            "amplitude_nm": math.hypot(sine, cosine),
            "period_s": term.inner[-1],
            "phase_rad": math.atan2(cosine, sine),
        }

    def implausible(self, term: Term, s: Signals) -> str:
        amplitude = math.hypot(*term.coefficients)
        for harmonic in range(1, 6):
            if _line(s, harmonic * term.inner[-1]) > 0.2:
                return "it would have the period of the command, or a harmonic of it: that is the vehicle's own motion"
        return "the wave would exceed every command" if amplitude > 1.5 * float(np.max(np.abs(s.torque))) else ""


def _line(s: Signals, period: float) -> float:
    """Part of the torque's variance that one sine of this period holds."""
    torque = s.torque - np.mean(s.torque)
    design = stack(*(f(2.0 * np.pi / period * (s.time - s.origin[0])) for f in (np.sin, np.cos)))
    theta, *_ = np.linalg.lstsq(design, torque, rcond=None)
    return 1.0 - float(np.var(torque - design @ theta) / max(float(np.var(torque)), 1e-300))
