"""The parameters of a vehicle's model, and their conversion to M, forces and filtered efforts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from incsvr.plant.terms import Term
from incsvr.vehicle.motion import WholeMotion

Pair = tuple[str, str]
"""Row and column of an entry of M, by the names of their axes; a symmetric entry is named once."""


@dataclass(frozen=True, slots=True)
class Structure:
    """The parameters of a vehicle's model, in this order: entries of M, coefficients of terms, time constants of lags.

    Attributes:
        axes: names of the axes that are simulated, in the order of ν; other recorded velocities enter as measured.
        mass: entries of M that are estimated.
        terms: terms that are linear in their coefficient.
        lags: axes whose effort follows its command with a first-order lag.
        fixed: (6, 6) entries of M that are declared; zero where they are estimated or absent.
    """

    axes: tuple[str, ...]
    mass: tuple[Pair, ...]
    terms: tuple[Term, ...]
    lags: tuple[str, ...]
    fixed: Array

    @property
    def size(self) -> int:
        """Number of parameters."""
        return len(self.mass) + len(self.terms) + len(self.lags)

    @property
    def rows(self) -> list[int]:
        """Places of the simulated axes in ν."""
        return [list(AXES).index(name) for name in self.axes]

    def with_term(self, term: Term) -> Structure:
        """The structure with one term more."""
        return replace(self, terms=(*self.terms, term))

    def with_lag(self, axis: str) -> Structure:
        """The structure with the lag of an axis's effort."""
        return replace(self, lags=(*self.lags, axis))

    def with_mass(self, pair: Pair) -> Structure:
        """The structure with one entry of M more."""
        return replace(self, mass=(*self.mass, pair))

    def only(self, kept: Sequence[int]) -> Structure:
        """The structure with some of its parameters alone, by their places in order."""
        masses, terms = len(self.mass), len(self.terms)
        return replace(
            self,
            mass=tuple(self.mass[k] for k in kept if k < masses),
            terms=tuple(self.terms[k - masses] for k in kept if masses <= k < masses + terms),
            lags=tuple(self.lags[k - masses - terms] for k in kept if k >= masses + terms),
        )

    def mass_matrix(self, parameters: Array) -> Array:
        """M (models, 6, 6) of parameters (models, size); an axis that is neither declared nor estimated has 1."""
        matrix = np.repeat(self.fixed[None], parameters.shape[0], axis=0)
        names = list(AXES)
        for k, (one, other) in enumerate(self.mass):
            row, column = names.index(one), names.index(other)
            matrix[:, row, column] = matrix[:, column, row] = parameters[:, k]
        return matrix

    def coefficients(self, parameters: Array) -> Array:
        """The coefficients of the terms, (models, terms)."""
        return parameters[:, len(self.mass) : len(self.mass) + len(self.terms)]

    def efforts(self, parameters: Array, motion: WholeMotion) -> Array:
        """τ (models or 1, n, 6) of the cells, after the lags of each model."""
        if not self.lags:
            return motion.effort[None]
        effort = np.repeat(motion.effort[None], parameters.shape[0], axis=0)
        constants = parameters[:, len(self.mass) + len(self.terms) :]
        for k, name in enumerate(self.lags):
            column = list(AXES).index(name)
            for model, constant in enumerate(constants[:, k].tolist()):
                for run in motion.runs:
                    effort[model, run, column] = lagged(motion.effort[run, column], constant, motion.step)
        return effort


def lagged(effort: Array, constant: float, step: float) -> Array:
    """Means over the cells (n,) of an effort that follows its command, constant in each cell, with a lag.

    Args:
        effort: (n,) the command; before the first cell it was what it is there.
        constant: time constant of the lag [s].
        step: length of a cell [s].
    """
    if constant < 1e-6 * step:
        return effort
    decay = float(np.exp(-step / constant))
    reached, _ = lfilter([1.0 - decay], [1.0, -decay], effort, zi=[decay * effort[0]])
    before = np.concatenate(([effort[0]], reached[:-1]))
    return np.asarray(effort + (before - effort) * (constant / step) * (1.0 - decay))


def coupled_pairs(axes: Sequence[str]) -> tuple[Pair, ...]:
    """Entries of M off its diagonal that a body whose port mirrors its starboard may have (Fossen 2011, Eq. 7.22)."""
    groups = (("surge", "heave", "pitch"), ("sway", "roll", "yaw"))
    return tuple(
        (one, other)
        for group in groups
        for k, one in enumerate(group)
        for other in group[k + 1 :]
        if one in axes and other in axes
    )
