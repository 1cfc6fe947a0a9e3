"""A hypothesis: damping, the streams' offset, and effects with their values, as one vector of free numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from incsvr.effects import Effect, Signals, Term
from incsvr.numerics import Array
from incsvr.tracing.damping import DampingBasis


@dataclass(frozen=True, slots=True)
class Part:
    """An effect with its values, which a fit moves unless they are fixed."""

    effect: Effect
    term: Term
    fixed: bool = False

    @property
    def name(self) -> str:
        return self.effect.name

    @property
    def coefficients(self) -> int:
        """The number of fitted coefficients: zero for an effect whose coefficient is one by nature."""
        return 0 if self.fixed or self.effect.fixed_coefficient else len(self.term.coefficients)

    @property
    def sought(self) -> tuple[int, ...]:
        """Places of the inner parameters that are searched."""
        return () if self.fixed else self.effect.sought

    @property
    def vector(self) -> Array:
        """(k,) the free numbers: coefficients, then the searched inner parameters."""
        searched = [self.term.inner[place] for place in self.sought]
        return np.array([*self.term.coefficients[: self.coefficients], *searched])

    def moved(self, vector: Array) -> Part:
        """The part with other free numbers (k,)."""
        count, values = self.coefficients, vector.tolist()
        coefficients = tuple(values[:count]) if count else self.term.coefficients
        inner = self.effect.moved(self.term.inner, values[count:]) if self.sought else self.term.inner
        return replace(self, term=replace(self.term, coefficients=coefficients, inner=inner))

    def bounds(self, signals: Signals) -> list[tuple[float, float]]:
        """Least and largest value of each free number."""
        of_coefficient = self.effect.coefficient_bounds(signals)
        found = [of_coefficient] * self.coefficients
        for place in self.sought:
            shape = self.effect.shapes if place == 0 else None
            found.append(shape or self.effect.bounds(signals))
        return found


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """The assumptions on a vehicle.

    Attributes:
        basis: of the damping.
        damping: (basis.size,) its coefficients.
        offset: by how much the torque acts later than it is stamped [s], within a sample.
        parts: the effects.
        offset_limit: beyond which an offset is no matter of sampling [s].
    """

    basis: DampingBasis
    damping: Array
    offset: float
    parts: tuple[Part, ...]
    offset_limit: float

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(part.name for part in self.parts)

    @property
    def vector(self) -> Array:
        """(p,) the free numbers: damping, offset, then those of each part."""
        return np.concatenate([self.damping, [self.offset], *(part.vector for part in self.parts)])

    def moved(self, vector: Array) -> Hypothesis:
        """The hypothesis with other free numbers (p,)."""
        size = self.basis.size
        at, parts = size + 1, []
        for part in self.parts:
            count = part.vector.size
            parts.append(part.moved(vector[at : at + count]))
            at += count
        return replace(self, damping=vector[:size], offset=float(vector[size]), parts=tuple(parts))

    def positions(self) -> Iterator[slice]:
        """The positions of each part's free numbers."""
        at = self.basis.size + 1
        for part in self.parts:
            yield slice(at, at + part.vector.size)
            at += part.vector.size

    def bounds(self, signals: Signals) -> tuple[Array, Array]:
        """(p,) each: what the free numbers are held within. A delay is the whole of the offset."""
        limit = 0.0 if "torque_delay" in self.names else self.offset_limit
        pairs = [(0.0, np.inf)] * self.basis.size + [(-limit, limit)]
        for part in self.parts:
            pairs += part.bounds(signals)
        low, high = np.array(pairs).T
        return low, high

    def with_part(self, part: Part) -> Hypothesis:
        """The hypothesis with one more effect."""
        offset = 0.0 if part.name == "torque_delay" else self.offset
        return replace(self, parts=(*self.parts, part), offset=offset)

    def without(self, k: int) -> Hypothesis:
        """The hypothesis without its k-th effect."""
        return replace(self, parts=self.parts[:k] + self.parts[k + 1 :])


def starts(effect: Effect, signals: Signals) -> Iterator[Part]:
    """The effect at every value from which it is searched."""
    for values in effect.starts(signals):
        if effect.fixed_coefficient:
            yield Part(effect, Term(effect.name, effect.variant, (1.0,), values))
        elif effect.from_start:
            yield Part(effect, Term(effect.name, effect.variant, values, ()))
        else:
            yield Part(effect, Term(effect.name, effect.variant, (0.0,) * effect.width(values), values))
