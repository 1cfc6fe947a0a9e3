"""Thrust that falls short at high command."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.special import ndtr

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.even_table import EvenTable
from incsvr.effects.signals import Array, Signals

LEAST = 0.03
"""Of the highest commands that a limit must take: a limit just above them takes but the torque's noise."""

HIGHEST = 0.999
"""Of the commands a limit may lie below: a controller asks for most but for instants, and loses most there."""

ROUND = (0.15, 0.3, 0.45)
"""Of the limit: widths of a rounded corner from which the search begins, from a supply that cuts to one that sags."""

WIDTHS = (0.05, 0.6)
"""Range of these."""

TABLED, CELLS = 4.0, 1000
"""Limits up to which a rounded one is tabled, for beyond no corner is left, and cells of that: the corner is wider than
twelve of them, and a line errs by 2e-5 of the limit."""

BEYOND = (0.6, 0.8, 1.0, 1.25)
"""Parts of the limit between which a true curve of thrust may bend otherwise."""


class Saturation(Effect):
    """a = τ clipped at ±L, the same with its corner rounded over a part of L, or L tanh(τ/L).

    Beyond the limit the rate side no longer knows the command, so the columns look at the predicted one: of noise
    on a command that stays near its highest, what exceeds a limit looks like a saturation.
    """

    name = "torque_saturation"
    sentence = "the thrust saturates: it does not follow the command beyond a limit"
    source = "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 12 (saturation)"
    acts = "thrust"
    stage = 2
    searched = True
    fixed_coefficient = True
    looks = 12.0

    def __init__(self, variant: Literal["limit", "rounded corner", "smooth limit"]) -> None:
        self.variant = variant
        self.shapes = WIDTHS if variant == "rounded corner" else None

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        limits = [float(limit) for limit in np.linspace(*self.bounds(s), 6)]
        if self.variant == "rounded corner":
            return [(width, limit) for width in ROUND for limit in limits]
        return [(limit,) for limit in limits]

    def bounds(self, s: Signals) -> tuple[float, float]:
        largest = float(np.quantile(np.abs(s.torque), HIGHEST))
        return (0.5 * largest, 2.5 * largest) if self.variant == "smooth limit" else (0.3 * largest, 0.97 * largest)

    def lost(self, command: Array, inner: tuple[float, ...]) -> Array:
        limit = inner[-1]
        if self.variant == "smooth limit":
            lost: Array = command - limit * np.tanh(command / limit)
            return lost
        if self.variant == "limit":
            return command - np.clip(command, -limit, limit)
        width = inner[0] * limit
        size, even = np.abs(command), np.linspace(0.0, TABLED * limit, CELLS + 1)
        inside = EvenTable(0.0, TABLED * limit / CELLS, _over(even - limit, width) - _over(-even - limit, width))
        rounded: Array = np.copysign(np.maximum(inside(size), size - limit), command)
        return rounded

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        return stack(s.over_jumps(s.predicted_torque, lambda command: self.lost(command, inner)))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"limit_nm": term.inner[-1]}

    def implausible(self, term: Term, s: Signals) -> str:
        if not 0.5 < term.coefficients[0] < 1.3:
            return f"beyond the limit {term.coefficients[0]:.0%} of the command would be lost, saturation loses all"
        largest = np.abs(s.predicted_torque)
        largest = largest[largest >= np.quantile(largest, 0.99)]
        part = float(np.mean(self.lost(largest, term.inner)) / np.mean(largest))
        if part < LEAST:
            return f"of the highest commands {part:.1%} would be lost, no more than their noise"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return command - term.coefficients[0] * s.over_jumps(command, lambda c: self.lost(c, term.inner))


def _over(excess: Array, width: float) -> Array:
    """max(x, 0) in the mean over a Gaussian of this width."""
    x = excess / width
    over: Array = width * (x * ndtr(x) + np.exp(-0.5 * x**2) / np.sqrt(2.0 * np.pi))
    return over


class SoftSaturation(Effect):
    """a = τ (1 − c |τ|): thrust falls short gradually (sagging supply, cavitation)."""

    name = "torque_saturation"
    variant = "coefficient"
    sentence = "the thrust falls short more and more at high command: a ≈ τ (1 − c |τ|)"
    source = "A. J. Healey et al., IEEE J. Oceanic Eng. 20(4), 1995 (thruster models with voltage sag)"
    acts = "thrust"
    stage = 2
    curved = True

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        if not s.from_rate:
            return stack(s.over_jumps(s.command, lambda command: command * np.abs(command)))
        c = min(max(coefficients[0], -0.2), 1.0) if coefficients else 0.0
        root = np.sqrt(np.maximum(1.0 - 4.0 * c * np.abs(s.applied), 0.04))
        command = 2.0 * s.applied / (1.0 + root)  # inverse of a = τ (1 − c |τ|)
        return stack(command * np.abs(command))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"coefficient": term.coefficients[0]}

    def implausible(self, term: Term, s: Signals) -> str:
        lost = term.coefficients[0] * float(np.quantile(np.abs(s.torque), 0.99))
        if lost <= 0.0:
            return "the thrust would gain, not lose, at high command"
        if lost > 0.6:
            return f"{lost:.0%} of the highest command would be lost"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        top = 0.5 / max(term.coefficients[0], 1e-12)  # the parabola's top: more command never gives less thrust

        def short(command: Array) -> Array:
            bounded = np.clip(command, -top, top)
            fallen: Array = bounded * (1.0 - term.coefficients[0] * np.abs(bounded))
            return fallen

        return s.over_jumps(command, short)
