"""The identified model of a whole vehicle, as a value: what a vehicle file holds and what simulates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from incsvr.plant.terms import Term, term
from incsvr.vehicle.motion import WholeMotion
from incsvr.vehicle.simulation import decay, simulate
from incsvr.vehicle.structure import Structure

ESTIMATED, DECLARED, ASSUMED = "estimated", "declared", "assumed"
UNKNOWN, BOUND_REACHED = "not excited", "bound reached"
"""The origins of a parameter. An inertia is assumed where its axis has no actuator, and any scale would do; a
parameter is not excited where its interval is wider than all of the axis's usual effort; an inertia's bound is
reached where the search ended at its edge, so that the recordings do not determine it."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of the model.

    Attributes:
        value: in SI units.
        low, high: ends of its interval of 95 %; the value itself where it is declared or assumed.
        origin: estimated, declared, assumed, not excited or bound reached.
    """

    value: float
    low: float
    high: float
    origin: str = ESTIMATED

    def to_dict(self) -> dict[str, Any]:
        return {"value": self.value, "low": self.low, "high": self.high, "origin": self.origin}

    @staticmethod
    def of(data: Mapping[str, Any]) -> Parameter:
        """The parameter of `to_dict`."""
        value = float(data["value"])
        origin = str(data.get("origin", ESTIMATED))
        return Parameter(value, float(data.get("low", value)), float(data.get("high", value)), origin)


@dataclass(frozen=True, slots=True)
class Vehicle:
    """M ν̇ + C(ν) ν + Σ c φ(ν, τ, η) = τ, with lags of the efforts.

    Attributes:
        name: as people call the vehicle.
        axes: names of the axes whose motion the model predicts, in the order of ν.
        driven: names of the axes whose effort acts.
        mass: entries of M by the names of both axes; one that is not named is zero, of an axis that is not predicted 1.
        terms: coefficients of the terms.
        lags: time constants of the efforts' lags [s] by axis.
        fastest: (6,) fastest velocities of the data [m/s], [rad/s]: beyond them the model is a guess.
        doubts: why predictions, parameters or intervals may be wrong, one sentence each.
    """

    name: str
    axes: tuple[str, ...]
    driven: tuple[str, ...]
    mass: Mapping[tuple[str, str], Parameter]
    terms: Mapping[Term, Parameter]
    lags: Mapping[str, Parameter]
    fastest: Array
    doubts: tuple[str, ...] = ()

    @property
    def structure(self) -> Structure:
        """The model's structure, with every entry of M among its parameters."""
        fixed = np.diag([float(name not in self.axes) for name in AXES])
        return Structure(self.axes, tuple(self.mass), tuple(self.terms), tuple(self.lags), fixed)

    @property
    def parameters(self) -> Array:
        """The values in the order of `structure`."""
        every = (*self.mass.values(), *self.terms.values(), *self.lags.values())
        return np.array([parameter.value for parameter in every])

    @property
    def mass_matrix(self) -> Array:
        """M (6, 6)."""
        return np.asarray(self.structure.mass_matrix(self.parameters[None])[0])

    @property
    def decay(self) -> float:
        """The largest rate at which a velocity decays within the data [1/s]."""
        rows = self.structure.rows
        inverse = np.linalg.inv(self.mass_matrix[np.ix_(rows, rows)])
        return decay(self.structure, self.parameters[None], np.asarray(inverse, dtype=np.float64)[None], self.fastest)

    def free_run(self, motion: WholeMotion) -> Array:
        """ν (n, 6) over the motion's one run, from its first velocities and the mean efforts of its cells."""
        first, held = np.zeros(1, dtype=np.intp), replace(motion, effort_rise=np.zeros_like(motion.effort_rise))
        course = simulate(self.structure, self.parameters[None], held, first, motion.velocity.shape[0] - 1)
        return course[:, 0, 0]

    def to_dict(self) -> dict[str, Any]:
        """The vehicle as plain data, in the form of a vehicle file."""
        terms: dict[str, dict[str, Any]] = {name: {} for name in self.axes}
        for each, parameter in self.terms.items():
            terms[each.axis][each.name] = {**parameter.to_dict(), "unit": each.unit}
        return {
            "vehicle_file": 1,
            "name": self.name,
            "axes": list(self.axes),
            "driven": list(self.driven),
            "mass_matrix": {f"{a},{b}": p.to_dict() for (a, b), p in self.mass.items()},
            "terms": terms,
            "thrust_lag_s": {name: parameter.to_dict() for name, parameter in self.lags.items()},
            "fastest": dict(zip(AXES, (float(value) for value in self.fastest), strict=True)),
            "doubts": list(self.doubts),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Vehicle:
        """The vehicle whose to_dict gave `data`."""
        terms = {
            term(axis, name): Parameter.of(parameter)
            for axis, named in data["terms"].items()
            for name, parameter in named.items()
        }
        mass = {_pair(key): Parameter.of(parameter) for key, parameter in data["mass_matrix"].items()}
        lags = {axis: Parameter.of(parameter) for axis, parameter in data["thrust_lag_s"].items()}
        fastest = np.array([float(data["fastest"][name]) for name in AXES])
        doubts = tuple(data.get("doubts", ()))
        return Vehicle(data["name"], _axes(data["axes"]), _axes(data["driven"]), mass, terms, lags, fastest, doubts)


def _axes(names: Sequence[str]) -> tuple[str, ...]:
    return tuple(name for name in AXES if name in set(names))


def _pair(key: str) -> tuple[str, str]:
    one, _, other = key.partition(",")
    return one, other
