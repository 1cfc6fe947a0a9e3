"""The description that every effect of the catalogue gives.

An effect is what the declared model I ṙ + d(r) = τ lacks. It stands between command and thrust (`thrust`), scales the
damping (`factor`), or takes a moment (`columns`, the moment for each coefficient by one):

    (I₀ + ΔI) ṙ = T(τ) − f d(r) − Σ_k θ_k φ_k(rate, heading, water, thrust, channels)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from incsvr.effects.signals import Signals
from incsvr.numerics import Array

__all__ = ["Effect", "Term", "stack"]


@dataclass(frozen=True, slots=True)
class Term:
    """An effect as it is in a model of the catalogue."""

    effect: str
    variant: str
    coefficients: tuple[float, ...]
    inner: tuple[float, ...] = ()


class Effect:
    """One physical effect; stateless.

    Attributes:
        name: as in the contract's vocabulary.
        variant: tells apart several forms under one name; empty for the only form.
        sentence: the physics, in one sentence in the field's words: a template of `AxisWords`, as reasons are.
        equation: how it changes I ṙ + d(r) = τ; `a` is what the thrusters make of the command τ.
        shown_by: what a recording must contain to show it, a template of `AxisWords`.
        source: where the physics is written down.
        acts: how it enters a simulation: `outside` a moment of time and channels alone; `motion` a moment that follows
            from rate, heading or thrust; `damping` a factor on d(r); `thrust` between command and thrust; `inertia`.
        stage: the order of thrust effects, from command to thrust.
        searched: whether the last inner parameter is continuous and searched.
        shapes: range of the first inner parameter where that is searched, too, else None.
        multiplicity: about how many independent values of the inner parameters a search tries (paid for in evidence).
        curved: whether the columns change with θ.
        channels: extra streams that it reads.
        fixed_coefficient: whether its coefficient is one by nature (inside a dead band all is lost).
        from_start: whether its coefficient is the parameter itself, which is searched from several values: a lag.
        ties: names of what the same data can never tell it from, whatever is driven.
        dry_friction: whether it is a friction of constant size, which can hold the vehicle.
        lingers: whether what it takes depends on the past of the command or the rate.
        needs_clock: whether it refers to the recording's absolute time.
        parameter_names: what the contract calls its parameters, where each is a number that is fitted.
    """

    name: str
    variant: str = ""
    sentence: str
    equation: str
    shown_by: ClassVar[str]
    source: ClassVar[str]
    acts: Literal["outside", "motion", "damping", "thrust", "inertia"]
    stage: ClassVar[int] = 0
    searched: bool = False
    shapes: tuple[float, float] | None = None
    multiplicity: float = 1.0
    curved: bool = False
    channels: tuple[str, ...] = ()
    fixed_coefficient: ClassVar[bool] = False
    from_start: ClassVar[bool] = False
    ties: ClassVar[tuple[str, ...]] = ()
    dry_friction: ClassVar[bool] = False
    lingers: ClassVar[bool] = False
    needs_clock: bool = False
    parameter_names: ClassVar[tuple[str, ...]] = ()

    @property
    def key(self) -> str:
        """Unique in a catalogue: name and variant."""
        return f"{self.name}/{self.variant}" if self.variant else self.name

    @property
    def sought(self) -> tuple[int, ...]:
        """Places in the inner parameters of those that are searched."""
        return ((0,) if self.shapes else ()) + ((-1,) if self.searched else ())

    def moved(self, inner: tuple[float, ...], values: Sequence[float]) -> tuple[float, ...]:
        """The inner parameters with other values of those that are searched."""
        found = list(inner)
        for place, value in zip(self.sought, values, strict=True):
            found[place] = value
        return tuple(found)

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        """Inner parameters, or the coefficient itself, from which the search begins."""
        return [()]

    def bounds(self, s: Signals) -> tuple[float, float]:
        """Range of the searched inner parameter; only asked when `searched`."""
        raise NotImplementedError(f"{self.key} has no searched parameter")

    def coefficient_bounds(self, s: Signals) -> tuple[float, float]:
        """The bounds of each coefficient in a fit."""
        return -np.inf, np.inf

    def width(self, inner: tuple[float, ...]) -> int:
        """The number of coefficients."""
        return 1

    def small(self, s: Signals, term: Term) -> float:
        """A coefficient so small that what it takes grows in proportion."""
        return 1.0

    def nudge(self, s: Signals, k: int) -> float:
        """The step of the k-th free number for a slope; 0 for a small part of it."""
        return 0.0

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        """φ, (n, width) [N m per unit of θ]; for `acts` outside and motion."""
        raise NotImplementedError(f"{self.key} takes no moment of its own")

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        """(n,) moment after this stage of the actuators [N m]; for `acts == "thrust"`."""
        raise NotImplementedError(f"{self.key} is no stage of the actuators")

    def command(self, thrust: Array, s: Signals, term: Term) -> Array:
        """(n,) command that this stage of the actuators makes into a moment [N m]: the inverse of `thrust`.

        Where no command makes the moment, the one that comes nearest. A delay is not undone: no instant's command can.
        """
        raise NotImplementedError(f"{self.key} is not inverted")

    def factor(self, s: Signals, term: Term) -> Array:
        """(n,) factor on d(r); for `acts == "damping"`."""
        raise NotImplementedError(f"{self.key} does not scale the damping")

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        """The contract's parameters of a fitted term; `inertia` is the declared one [kg m²].

        By `parameter_names` the coefficients that are not one by nature, and the last inner parameter where it is
        searched.
        """
        fitted = () if self.fixed_coefficient else term.coefficients
        return dict(zip(self.parameter_names, fitted + term.inner[-1:] * self.searched, strict=True))

    def implausible(self, term: Term, s: Signals) -> str:
        """The reason why physics forbids this term; empty if it does not."""
        return ""

    def below_relevance(self, term: Term, s: Signals) -> str:
        """The reason why the term is within the accuracy of a declaration; empty if it is beyond."""
        return ""


def stack(*columns: Array) -> Array:
    """Columns side by side, (n, c)."""
    return columns[0][:, None] if len(columns) == 1 else np.stack(columns, axis=1)
