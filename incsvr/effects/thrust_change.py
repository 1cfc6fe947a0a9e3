"""Thrust that is lost, or comes back, at an instant or by and by."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from incsvr.effects.effect import Effect, Term
from incsvr.effects.signals import Signals
from incsvr.numerics import Array

MIN_THRUST_SHARE = 0.1
"""Part of the thrust that the table says which is left at least."""
MAX_THRUST_SHARE = 3.0
"""Part of the thrust that the table says which is left at most."""

THRUST_TABLE_ERROR = 0.05
"""Part of the thrust: no table is better known, and what its error leaves of an effect looks like so small a change."""

EDGE_SHARE = 0.04
"""Part of the recordings at either end within which no step is sought."""


class _ThrustOfTime(Effect, ABC):
    """a = (1 + f p) τ with p from 0 to 1 over time."""

    acts = "thrust"
    stage = 4
    needs_clock = True

    @abstractmethod
    def progress(self, s: Signals, inner: tuple[float, ...]) -> Array:
        """(n,) p, from 0 to 1."""

    def small(self, s: Signals, term: Term) -> float:
        return 0.02

    def implausible(self, term: Term, s: Signals) -> str:
        left = 1.0 + term.coefficients[0]
        return (
            ""
            if MIN_THRUST_SHARE < left < MAX_THRUST_SHARE
            else f"the thrust would become {left:.2g} times its table's value"
        )

    def below_relevance(self, term: Term, s: Signals) -> str:
        if abs(term.coefficients[0]) < THRUST_TABLE_ERROR:
            return (
                f"the thrust would change by less than {THRUST_TABLE_ERROR:.0%}, which is within the error of its table"
            )
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return np.asarray(
            command
            * np.clip(1.0 + term.coefficients[0] * self.progress(s, term.inner), MIN_THRUST_SHARE, MAX_THRUST_SHARE)
        )


class ThrustStep(_ThrustOfTime):
    """A thruster that fails, or that something fouls, at the instant t_s."""

    name = "thrust_step"
    sentence = "the thrust jumps at one instant: a thruster fails or is fouled, or one comes back"
    source = "G. Antonelli, Underwater Robots, 2014, ch. 4 (faults of thrusters)"
    equation = "a = τ, from the instant t_s on a = (1 + f) τ"
    shown_by = "the same {effort}s before and after the instant"
    searched = True
    multiplicity = 25.0
    parameter_names = ("fraction", "at_s")

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        return [(float(at),) for at in np.linspace(*self.bounds(s), 25)]

    def bounds(self, s: Signals) -> tuple[float, float]:
        begin, end = s.origin
        return begin + EDGE_SHARE * (end - begin), end - EDGE_SHARE * (end - begin)

    def nudge(self, s: Signals, k: int) -> float:
        return 0.5 * s.block if k == 1 else 0.0

    def progress(self, s: Signals, inner: tuple[float, ...]) -> Array:
        return np.asarray(np.clip((s.time - inner[-1]) / s.block + 0.5, 0.0, 1.0))


class ThrustDrift(_ThrustOfTime):
    """A supply that sags with its charge: the thrust drifts over the fitted recordings."""

    name = "thrust_drift"
    sentence = "the thrust drifts over the recording, as with the charge of a battery"
    source = "A. J. Healey et al., IEEE J. Oceanic Eng. 20(4), 1995 (motor voltage and thrust)"
    equation = "a = (1 + f p) τ, p from 0 to 1 over the recordings"
    shown_by = "the same {effort}s early and late in the recordings"
    parameter_names = ("fraction",)

    def progress(self, s: Signals, inner: tuple[float, ...]) -> Array:
        return s.progress
