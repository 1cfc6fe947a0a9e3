"""Thrust that falls short at high command."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.special import ndtr

from incsvr.effects.effect import Effect, Term
from incsvr.effects.even_table import EvenTable
from incsvr.effects.signals import Signals
from incsvr.numerics import Array

MIN_LOSS_SHARE = 0.03
"""Part of the highest commands that a limit must take: a limit just above them takes but the torque's noise."""

HIGHEST_COMMAND_QUANTILE = 0.999
"""Quantile of the commands that counts as the highest: a controller asks for most but for instants, and loses most."""

ROUND_START_WIDTHS = (0.15, 0.3, 0.45)
"""Widths of a rounded corner from which the search begins, in parts of the limit."""
ROUND_WIDTH_RANGE = (0.05, 0.6)
"""Range of these widths, from a supply that cuts to one that sags."""

TABLE_LIMITS = 4.0
"""Limits up to which a rounded one is tabled, for beyond no corner is left."""
INVERSE_LIMITS = 2.0
"""Limits up to which a command is sought for a thrust; of a smooth limit so much gives 96 % of the most."""
TABLE_CELL_COUNT = 1000
"""Cells of that table."""


SENTENCE_OF_VARIANT = {
    "limit": "the thrust saturates: it does not follow the command beyond a limit",
    "rounded corner": "the thrust saturates: it bends into a limit that it never exceeds",
    "smooth limit": "the thrust saturates gradually as L tanh(τ/L): a quarter is lost at τ = L, and L is never reached",
}
"""The limit L of each variant means another thrust, so each variant says which."""
EQUATION_OF_VARIANT = {
    "limit": "a = τ for |τ| < L, a = L sgn(τ) otherwise",
    "rounded corner": "a = τ for small τ, bent into a = L sgn(τ) over a part of L",
    "smooth limit": "a = L tanh(τ/L)",
}


class Saturation(Effect):
    """a = τ clipped at ±L, the same with its corner rounded over a part of L, or L tanh(τ/L)."""

    name = "torque_saturation"
    source = "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, ch. 12 (saturation)"
    shown_by = "commands beyond the limit, beside smaller ones"
    acts = "thrust"
    stage = 2
    searched = True
    fixed_coefficient = True
    multiplicity = 12.0
    parameter_names = ("limit_nm",)

    def __init__(self, variant: Literal["limit", "rounded corner", "smooth limit"]) -> None:
        self.variant = variant
        self.sentence = SENTENCE_OF_VARIANT[variant]
        self.equation = EQUATION_OF_VARIANT[variant]
        self.shapes = ROUND_WIDTH_RANGE if variant == "rounded corner" else None

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        limits = [float(limit) for limit in np.linspace(*self.bounds(s), 6) if limit > 0.0]
        if self.variant == "rounded corner":
            return [(width, limit) for width in ROUND_START_WIDTHS for limit in limits]
        return [(limit,) for limit in limits]

    def bounds(self, s: Signals) -> tuple[float, float]:
        largest = float(np.quantile(np.abs(s.torque), HIGHEST_COMMAND_QUANTILE))
        return (0.5 * largest, 2.5 * largest) if self.variant == "smooth limit" else (0.3 * largest, 0.97 * largest)

    def lost(self, command: Array, inner: tuple[float, ...]) -> Array:
        """(n,) what the limit takes of the command [N m]."""
        limit = inner[-1]
        if self.variant == "smooth limit":
            return np.asarray(command - limit * np.tanh(command / limit))
        if self.variant == "limit":
            return np.asarray(command - np.clip(command, -limit, limit))
        width = inner[0] * limit
        size, even = np.abs(command), np.linspace(0.0, TABLE_LIMITS * limit, TABLE_CELL_COUNT + 1)
        inside = EvenTable(
            0.0, TABLE_LIMITS * limit / TABLE_CELL_COUNT, _over(even - limit, width) - _over(-even - limit, width)
        )
        return np.asarray(np.copysign(np.maximum(inside(size), size - limit), command))

    def implausible(self, term: Term, s: Signals) -> str:
        largest = np.abs(s.torque)
        largest = largest[largest >= np.quantile(largest, 0.99)]
        part = float(np.mean(self.lost(largest, term.inner)) / np.mean(largest))
        return (
            f"of the highest commands {part:.1%} would be lost, no more than their noise"
            if part < MIN_LOSS_SHARE
            else ""
        )

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return command - term.coefficients[0] * self.lost(command, term.inner)

    def command(self, thrust: Array, s: Signals, term: Term) -> Array:
        limit = term.inner[-1]
        if self.variant == "limit":
            return np.clip(thrust, -limit, limit)
        size = np.linspace(0.0, INVERSE_LIMITS * limit, TABLE_CELL_COUNT + 1)
        made = size - self.lost(size, term.inner)
        rising = np.concatenate(([True], np.diff(np.maximum.accumulate(made)) > 0.0))
        return np.asarray(np.copysign(np.interp(np.abs(thrust), made[rising], size[rising]), thrust))


def _over(excess: Array, width: float) -> Array:
    """max(x, 0) in the mean over a Gaussian of this width."""
    x = excess / width
    return np.asarray(width * (x * ndtr(x) + np.exp(-0.5 * x**2) / np.sqrt(2.0 * np.pi)))


class SoftSaturation(Effect):
    """a = τ (1 − c |τ|): thrust falls short gradually (sagging supply, cavitation)."""

    name = "torque_saturation"
    variant = "coefficient"
    sentence = "the thrust falls short more and more at high command: a ≈ τ (1 − c |τ|)"
    source = "A. J. Healey et al., IEEE J. Oceanic Eng. 20(4), 1995 (thruster models with voltage sag)"
    equation = "a = τ (1 − c |τ|)"
    shown_by = "commands up to the highest, beside smaller ones"
    acts = "thrust"
    stage = 2
    parameter_names = ("coefficient",)

    def small(self, s: Signals, term: Term) -> float:
        return 0.02 / max(float(np.quantile(np.abs(s.torque), 0.99)), 1e-300)

    def implausible(self, term: Term, s: Signals) -> str:
        lost = term.coefficients[0] * float(np.quantile(np.abs(s.torque), 0.99))
        if lost <= 0.0:
            return "the thrust would gain, not lose, at high command"
        return f"{lost:.0%} of the highest command would be lost" if lost > 0.6 else ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        top = 0.5 / max(term.coefficients[0], 1e-12)  # the parabola's top: more command never gives less thrust
        bounded = np.clip(command, -top, top)
        return np.asarray(bounded * (1.0 - term.coefficients[0] * np.abs(bounded)))

    def command(self, thrust: Array, s: Signals, term: Term) -> Array:
        loss = max(term.coefficients[0], 1e-12)
        root = np.sqrt(np.maximum(1.0 - 4.0 * loss * np.abs(thrust), 0.0))
        return np.asarray(np.copysign(2.0 * np.abs(thrust) / (1.0 + root), thrust))
