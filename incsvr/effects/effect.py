"""What every effect of the catalogue says about itself.

An effect is what the declared model I ṙ + d(r) = τ lacks. Each one writes the torque that it takes as regressors,

    τ = I ṙ + d(r) + Σ_k θ_k φ_k(signals; inner parameters),

so that θ is found by linear regression and only the inner parameters are searched. The regressors of thrust effects are
built from the rate side (the moment that must have acted), because one built from the recorded torque shares its noise.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from incsvr.effects.signals import Array, Signals

BESIDE = 0.1
"""Of the way from one start of a searched parameter to the next: closer than that a value is at that start."""


@dataclass(frozen=True, slots=True)
class Term:
    """An effect as it stands in a model.

    Attributes:
        effect: its name in the catalogue, with the channel if it has one.
        variant: which form of the effect (see `Effect.variant`).
        coefficients: θ, one for each column.
        inner: the parameters that are searched; a shape, if any, first, and the size that the effect is known by last.
    """

    effect: str
    variant: str
    coefficients: tuple[float, ...]
    inner: tuple[float, ...] = ()


class Effect(ABC):
    """One physical effect; stateless.

    Attributes:
        name: as in the contract's vocabulary.
        variant: tells apart several forms under one name; empty for the only form.
        sentence: the physics, in one sentence in the field's words.
        source: where the physics is written down.
        acts: how it enters a simulation: `outside` a moment of time and channels alone; `motion` a moment that follows
            from rate, heading or thrust; `damping` a factor on d(r); `thrust` between command and thrust; `inertia`.
        stage: the order of thrust effects, from command to thrust.
        core: how many of the columns carry the effect; the others only place its zero (an offset, a reference).
        searched: whether the last inner parameter is continuous and searched.
        shapes: range of the first inner parameter where that is searched, too, else None.
        looks: about how many independent values of the inner parameters a search tries (paid for in evidence).
        curved: whether the columns change with θ, so that the fit is repeated.
        channels: extra streams that it reads.
        fixed_coefficient: whether its coefficient is one by nature (inside a dead band all is lost): the inner
            parameter is searched with that, or the two would stand for each other.
        secant: whether its first column is the secant to the start of the search, to which that value belongs as the
            coefficient: with a free one a short delay would pass for any other, and a wrong one for its own opposite.
        shifts: whether it moves the thrust in time and leaves it as it is: the torque's noise moves with it.
        dry_friction: whether it is a friction of constant size, which can hold the vehicle.
        lingers: whether what it takes depends on the past of the command or the rate.
        needs_clock: whether it refers to the recording's absolute time.
        beside: name of the effect without which this form is no other than the plain one; empty for none.
    """

    name: str
    variant: str = ""
    sentence: ClassVar[str]
    source: ClassVar[str]
    acts: Literal["outside", "motion", "damping", "thrust", "inertia"]
    stage: ClassVar[int] = 0
    core: int = 1
    searched: bool = False
    shapes: tuple[float, float] | None = None
    looks: float = 1.0
    curved: bool = False
    channels: tuple[str, ...] = ()
    fixed_coefficient: ClassVar[bool] = False
    secant: ClassVar[bool] = False
    shifts: ClassVar[bool] = False
    dry_friction: ClassVar[bool] = False
    lingers: ClassVar[bool] = False
    needs_clock: bool = False
    beside: ClassVar[str] = ""

    @property
    def key(self) -> str:
        """Unique in a catalogue: name and variant."""
        return f"{self.name}/{self.variant}" if self.variant else self.name

    @property
    def of_phase(self) -> bool:
        """Whether, under a periodic command, the effect is a function of the command's phase alone."""
        return self.acts in ("motion", "thrust", "inertia") and not self.channels

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
        """Inner parameters from which the search begins."""
        return [()]

    def bounds(self, s: Signals) -> tuple[float, float]:
        """Range of the searched inner parameter; only asked when `searched`."""
        raise NotImplementedError(f"{self.key} has no searched parameter")

    def bracket(self, s: Signals, inner: tuple[float, ...]) -> tuple[float, float]:
        """Where the searched parameter is refined: between the neighbours of its start, or of what it came to.

        A value that came to lie beside a neighbour may have been held up there: it goes up to the next one.
        """
        edges = [*self.bounds(s), *(start[-1] for start in self.starts(s))]
        value = inner[-1]
        below = max((edge for edge in edges if edge < value), default=value)
        above = min((edge for edge in edges if edge > value), default=value)
        near = BESIDE * (above - below)
        return (
            max((edge for edge in edges if edge <= value - near), default=below),
            min((edge for edge in edges if edge >= value + near), default=above),
        )

    @abstractmethod
    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        """φ(t), (n, c) [N m per unit of θ]; `coefficients` are those of the last pass (empty in the first)."""

    def offset(self, s: Signals, coefficients: tuple[float, ...], columns: Array) -> Array | None:
        """(n,) loss(θ) − φ θ [N m] where φ, the `columns`, is but the tangent of a curved loss; None elsewhere."""
        return None

    def passed(self, term: Term, s: Signals) -> Array | None:
        """(64,) part of the torque's noise that its regressor leaves in the equation, frequencies from zero to π/T_b.

        A filter on the recorded torque filters its noise, too; it must not be rewarded for that. None for no filter.
        """
        return None

    @abstractmethod
    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        """The contract's parameters of a fitted term; `inertia` is the declared one [kg m²]."""

    def implausible(self, term: Term, s: Signals) -> str:
        """Why physics forbids this term; empty if it does not."""
        return ""

    def slight(self, term: Term, s: Signals) -> str:
        """Why it is no more than what nobody declares more closely; empty if it is more.

        Beside another effect it may be more: a search grows it further, and it is not named.
        """
        return ""

    def must_prove(self, term: Term, s: Signals) -> bool:
        """Whether the noise's colour might be taken for it, so that only a free run that is plainly better counts."""
        return False

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        """Moment after this stage of the actuators; for `acts == "thrust"`."""
        raise NotImplementedError(f"{self.key} is no stage of the actuators")

    def factor(self, s: Signals, term: Term) -> Array:
        """(n,) factor on d(r); for `acts == "damping"`."""
        raise NotImplementedError(f"{self.key} does not scale the damping")


def stack(*columns: Array) -> Array:
    """Columns side by side, (n, c)."""
    return columns[0][:, None] if len(columns) == 1 else np.stack(columns, axis=1)
