"""A periodic moment."""

from __future__ import annotations

import math

import numpy as np

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Signals
from incsvr.numerics import Array


class Wave(Effect):
    """A sin(2π t/P + φ), t from the start of the fitted recordings."""

    name = "wave"
    sentence = "a periodic {moment} acts that depends on time alone, as of regular waves"
    source = "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 8 (wave moments)"
    equation = "I ṙ + d(r) = τ + A sin(2π t/P + φ)"
    shown_by = "many periods, with commands of other periods"
    acts = "outside"
    searched = True
    multiplicity = 300.0
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

    def width(self, inner: tuple[float, ...]) -> int:
        return 2

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
        if _harmonic(s, term.inner[-1], amplitude):
            return "it would have the period of the command, or a harmonic of it: that is the vehicle's own motion"
        commanded, above = _line(s, 1.0 / term.inner[-1])
        if (
            above > LINE_POWER_RATIO
            and commanded > 2.0 * amplitude
            and not _isolated(s, 1.0 / term.inner[-1], commanded, amplitude)
        ):
            return "the command has a line of this period: that is the vehicle's own motion"
        return "the wave would exceed every command" if amplitude > 1.5 * float(np.max(np.abs(s.torque))) else ""


MAX_HARMONIC = 15
"""Highest harmonic of a periodic command that is looked at: as far as the shape error of an effect of the motion
reaches."""

MAX_ISOLATED_HARMONIC = 3
"""Highest harmonic that a motion may have alone: of r² the second, of r |r| mostly the third."""

MIN_NEIGHBOUR_SHARE = 0.3
"""Part of a higher harmonic's amplitude which another harmonic of the same motion has at least."""

LINE_POWER_RATIO = 12.0
"""Power of a line over that of its neighbourhood; noise gets there once in e¹² times."""

NEAR_FREQUENCY_SHARE = 0.15
"""Part of a line's frequency within which the vehicle answers others of the command alike."""
MIN_NEAR_LINES = 4
"""Others of the command near a line, at least: a sweep that is driven again and again has them."""


def _harmonic(s: Signals, period: float, amplitude: float) -> bool:
    """Whether the command is a line and the period, as far as the recording resolves it, that of a harmonic.

    Of a line among others the motion that bends so sharply as to have a high one has more of them; a wave comes alone.
    """
    finest = 1.0 / (s.origin[1] - s.origin[0])
    a_fifth, half = np.sqrt(0.4 * np.var(s.torque)), np.std(s.torque)  # of a sine that holds as much of the variance
    for harmonic in range(1, MAX_HARMONIC + 1):
        first = 1.0 / period / harmonic
        (here,) = _tones(s, s.torque, np.array([first]))
        if here > a_fifth and here >= max(_tones(s, s.torque, first + np.array([-finest, finest]) / harmonic)):
            others = np.array([k for k in range(1, MAX_HARMONIC + 1) if k != harmonic]) * first
            isolated = (
                harmonic > MAX_ISOLATED_HARMONIC
                and here < half
                and np.max(_tones(s, s.residual, others)) < MIN_NEIGHBOUR_SHARE * amplitude
            )
            if not isolated:
                return True
    return False


def _line(s: Signals, frequency: float) -> tuple[float, float]:
    """The torque's amplitude at a frequency [N m], and its power there over the mean of the neighbourhood."""
    length = s.origin[1] - s.origin[0]
    apart = np.array([k for k in range(-9, 10) if abs(k) > 2 and frequency + k / length > 0.0] or [3]) / length
    tones = _tones(s, s.torque, frequency + np.concatenate([[0.0], apart]))
    return float(tones[0]), float(tones[0] ** 2 / max(np.mean(tones[1:] ** 2), 1e-300))


def _isolated(s: Signals, frequency: float, commanded: float, amplitude: float) -> bool:
    """Whether next to nothing is left where the command has lines near this one, of half its size [N m] at least: of
    the vehicle's own motion as much would be left there."""
    length = s.origin[1] - s.origin[0]
    apart = np.arange(3, 1 + int(NEAR_FREQUENCY_SHARE * frequency * length)) / length
    near = frequency + np.concatenate([-apart, apart])
    lines = near[_tones(s, s.torque, near) >= 0.5 * commanded] if near.size else near
    return lines.size >= MIN_NEAR_LINES and bool(np.max(_tones(s, s.residual, lines)) < MIN_NEIGHBOUR_SHARE * amplitude)


def _tones(s: Signals, values: Array, frequency: Array) -> Array:
    """(k,) amplitude of `values` (n,) at each frequency; `frequency` (k,) in Hz."""
    hop = max(round(s.block / s.step), 1)
    centred = (values - np.mean(values))[::hop]
    phase = 2.0 * np.pi * frequency[:, None] * (s.time[::hop] - s.origin[0])
    tones: Array = np.hypot(np.cos(phase) @ centred, np.sin(phase) @ centred) * 2.0 / centred.size
    return tones
