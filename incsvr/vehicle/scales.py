"""The start of the search for a vehicle's parameters, their orders of magnitude, and the bounds of physics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from incsvr.numerics import Array, root_mean_square
from incsvr.plant.axes import AXES, VELOCITIES
from incsvr.plant.terms import BIAS, EFFORT, INFLOW, LINEAR, QUADRATIC, REVERSE, RIGHTING, WEIGHT, Term
from incsvr.vehicle.fitting import Fit
from incsvr.vehicle.motion import WholeMotion
from incsvr.vehicle.structure import Pair, Structure

Candidate: TypeAlias = Term | str | Pair
"""A candidate addition to a structure: a term, the lag of an axis's effort by its name, or an entry of M."""
MASS_RANGE = 30.0
"""Factor by which an inertia may differ from its first guess: a guess from accelerations is rarely off by ten."""
PASSIVE_SHARE = 0.3
"""Effort of an axis without actuators, in that of the most driven one of its kind: Coriolis forces are so large."""
MAX_LAG_CELLS = 40.0
"""Longest lag, in cells."""


@dataclass(frozen=True, slots=True)
class Extension:
    """A structure with one parameter more than the present one.

    Attributes:
        structure: with the candidate.
        start: its parameters: the fitted ones, and the candidate's first value.
        scale: their scales.
        place: which of them is the candidate's.
    """

    structure: Structure
    start: Array
    scale: Array
    place: int


@dataclass(frozen=True, slots=True)
class Scales:
    """The orders of magnitude of a motion.

    Attributes:
        speed: (6,) RMS velocities.
        effort: (6,) RMS efforts, estimated where an axis is passive.
        inertia: (6,) first guesses of the diagonal of M.
        step: length of a cell [s].
    """

    speed: Array
    effort: Array
    inertia: Array
    step: float

    @staticmethod
    def of(motion: WholeMotion, declared: Mapping[str, float]) -> Scales:
        """The scales of a motion; inertias that are declared by the axes' names are taken as they are."""
        speed = np.array([root_mean_square(motion.velocity[:, k]) for k in range(6)]) + 1e-9
        effort = np.array([root_mean_square(motion.effort[:, k]) for k in range(6)])
        for group in (slice(0, 3), slice(3, 6)):
            effort[group] = np.maximum(effort[group], PASSIVE_SHARE * float(effort[group].max()))
        effort = np.maximum(effort, PASSIVE_SHARE * float(effort.max()) * (effort == 0.0)) + 1e-9
        guesses = np.array([_inertia(motion, k, speed[k], effort[k]) for k in range(6)])
        for group in (slice(0, 3), slice(3, 6)):
            driven = np.array([np.ptp(motion.effort[:, k]) > 0.0 for k in range(6)])[group]
            if driven.any():
                guesses[group] = np.where(driven, guesses[group], float(np.max(guesses[group][driven])))
        for name, value in declared.items():
            guesses[list(AXES).index(name)] = value
        return Scales(speed, effort, guesses, motion.step)

    def of_term(self, term: Term) -> float:
        """The order of a term's coefficient."""
        own = self.speed[term.row]
        force = self.effort[term.row]
        if term.kind == LINEAR:
            return float(force / own)
        if term.kind == QUADRATIC:
            return float(force / own**2)
        if term.kind in (REVERSE, EFFORT):
            return 0.5
        if term.kind == INFLOW:
            return float(0.5 / self._speed_of(term))
        if term.kind in (BIAS, WEIGHT):
            return float(0.1 * force)
        if term.kind == RIGHTING:
            return float(force)
        return float(0.5 * force / self._speed_of(term))

    def _speed_of(self, term: Term) -> float:
        speeds = [float(self.speed[VELOCITIES.index(name)]) for name in term.of if name in VELOCITIES]
        return float(np.prod(speeds)) * (speeds[0] if term.kind == "square" else 1.0)

    def of_mass(self, pair: tuple[str, str]) -> float:
        """The order of an entry of M."""
        one, other = (self.inertia[list(AXES).index(name)] for name in pair)
        return float(one) if pair[0] == pair[1] else 0.2 * float(np.sqrt(one * other))

    def start(self, structure: Structure) -> tuple[Array, Array]:
        """First values and scales (size,) of a structure's parameters."""
        mass = [self.of_mass(pair) for pair in structure.mass]
        terms = [self.of_term(term) for term in structure.terms]
        first = [0.5 * value if term.dissipates else 0.0 for term, value in zip(structure.terms, terms, strict=True)]
        begin = [value if one == other else 0.0 for value, (one, other) in zip(mass, structure.mass, strict=True)]
        lags = [self.step] * len(structure.lags)
        return np.array([*begin, *first, *lags]), np.array([*mass, *terms, *lags])

    def bounds(self, structure: Structure) -> tuple[Array, Array]:
        """Lower and upper bounds (size,) of a structure's parameters."""
        low, high = [], []
        for one, other in structure.mass:
            value = self.of_mass((one, other))
            low.append(value / MASS_RANGE if one == other else -np.inf)
            high.append(value * MASS_RANGE if one == other else np.inf)
        for term in structure.terms:
            low.append(0.0 if term.dissipates or term.kind == RIGHTING else -1.0 if term.kind == REVERSE else -np.inf)
            high.append(0.95 if term.kind == REVERSE else np.inf)
        low += [0.0] * len(structure.lags)
        high += [MAX_LAG_CELLS * self.step] * len(structure.lags)
        return np.array(low), np.array(high)

    def extension(self, fitted: Fit, candidate: Candidate) -> Extension:
        """The structure with a candidate, its parameters the fitted ones and a first value that changes nothing."""
        structure = fitted.structure
        masses, terms = len(structure.mass), len(structure.terms)
        if isinstance(candidate, Term):
            wider, place, scale, first = structure.with_term(candidate), masses + terms, self.of_term(candidate), 0.0
        elif isinstance(candidate, str):
            wider, place = structure.with_lag(candidate), structure.size
            scale, first = self.step, 0.25 * self.step
        else:
            wider, place, scale, first = structure.with_mass(candidate), masses, self.of_mass(candidate), 0.0
        return Extension(
            wider, np.insert(fitted.parameters, place, first), np.insert(fitted.scale, place, scale), place
        )


def _inertia(motion: WholeMotion, axis: int, speed: float, effort: float) -> float:
    """A first guess of M_ii: least squares of the effort over acceleration and drag, or the ratio of their sizes."""
    parts = [motion.velocity[run, axis] for run in motion.runs]
    rise = np.concatenate([np.diff(part) / motion.step for part in parts])
    now = np.concatenate([0.5 * (part[1:] + part[:-1]) for part in parts])
    force = np.concatenate([motion.effort[run, axis][:-1] for run in motion.runs])
    if not np.ptp(rise) > 0.0:
        return 1.0
    columns = np.column_stack([rise, now, now * np.abs(now)])
    guess = float(np.linalg.lstsq(columns, force, rcond=None)[0][0])
    ratio = effort / root_mean_square(rise)
    return guess if guess > 0.05 * ratio else ratio
