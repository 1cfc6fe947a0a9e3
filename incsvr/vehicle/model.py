"""The identified model of a whole vehicle, as a value: what a vehicle file holds and what simulates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from incsvr.model.rows import Row
from incsvr.model.series import effort_of
from incsvr.model.simulation import predict
from incsvr.model.structure import NO_PRIOR, Structure
from incsvr.model.windows import cut
from incsvr.numerics import Array, Stream, Streams
from incsvr.plant.axes import AXES, VELOCITIES
from incsvr.plant.terms import BEND, COULOMB, LINEAR, QUADRATIC, RIGHTING, WEIGHT, Term, term
from incsvr.vehicle.equation import STAGES, rates, row_of, static_stage
from incsvr.vehicle.runs import is_held

ESTIMATED, DECLARED, ASSUMED = "estimated", "declared", "assumed"
UNKNOWN, BOUND_REACHED = "not excited", "bound reached"
"""The origins of a parameter. All of an axis that has no actuator is assumed, because any scale would do; a
parameter is not excited where its interval is wider than all of the axis's usual effort; an inertia's bound is
reached where the search ended at its edge, so that the recordings do not determine it."""

STEPS_A_DECAY = 2.5
"""Steps of a simulation in the time in which the fastest velocity decays, as in the engine's fits."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of the model.

    Attributes:
        value: in SI units.
        low, high: ends of its interval of 95 % (at the assumed scale if assumed); both the value if declared.
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
        thrust: what the actuators of an axis make of its effort, by axis: stages, as in `incsvr.vehicle.equation`.
        beaten_by: `zero` or `hold`, which predicts unseen data better than the model; empty where none does.
    """

    name: str
    axes: tuple[str, ...]
    driven: tuple[str, ...]
    mass: Mapping[tuple[str, str], Parameter]
    terms: Mapping[Term, Parameter]
    lags: Mapping[str, Parameter]
    fastest: Array
    doubts: tuple[str, ...] = ()
    thrust: Mapping[str, Mapping[str, Parameter]] = field(default_factory=dict)
    beaten_by: str = ""

    @property
    def rows(self) -> list[int]:
        """Places of the axes in ν."""
        return [list(AXES).index(name) for name in self.axes]

    @property
    def mass_matrix(self) -> Array:
        """M (6, 6)."""
        names, found = list(AXES), np.diag([float(name not in self.axes) for name in AXES])
        for (one, other), parameter in self.mass.items():
            row, column = names.index(one), names.index(other)
            found[row, column] = found[column, row] = parameter.value
        return np.asarray(found)

    @property
    def decay(self) -> float:
        """The largest rate at which a velocity decays within the data [1/s]."""
        slope = np.zeros(6)
        for each, parameter in self.terms.items():
            factor = {LINEAR: 1.0, BEND: 1.0, QUADRATIC: 2.0 * self.fastest[each.row]}.get(each.kind, 0.0)
            factor = 1.0 / float(each.of[0]) if each.kind == COULOMB else factor
            slope[each.row] += factor * abs(parameter.value)
        inverse = np.linalg.inv(self.mass_matrix[np.ix_(self.rows, self.rows)])
        return float((slope[self.rows] * np.diag(inverse)).max(initial=0.0))

    @property
    def rotor_lags(self) -> dict[str, Parameter]:
        """Time constants of the lags of the rotors' speeds [s] by axis."""
        kind = STAGES["spin"]
        return {axis: of[kind] for axis, of in self.thrust.items() if kind in of}

    @property
    def all_lags(self) -> dict[str, Parameter]:
        """Time constants of the lags of thrust and of rotors' speeds [s] by axis, of which each has one at most."""
        return {**self.lags, **self.rotor_lags}

    def equation(self) -> tuple[Structure, dict[str, float]]:
        """The model for the engine, without the static stages of its thrust, and its parameters' values by name."""
        rows = {each: row_of(each) for each in self.terms}
        known = {*rates(self.axes), *self._efforts, "roll", "pitch", ""}
        measured = tuple(v for v in VELOCITIES if v not in known and any(v in _signals(row) for row in rows.values()))
        rows = {each: row for each, row in rows.items() if _signals(row) <= {*known, *measured}}
        mass = {
            "*".join(rates(tuple(dict.fromkeys(pair)))): p.value
            for pair, p in self.mass.items()
            if {*pair} <= {*self.axes}
        }
        delays = {AXES[axis].rate: of["delay_s"].value for axis, of in self.thrust.items() if "delay_s" in of}
        lags = {
            ("spin" if axis in self.rotor_lags else "lag", AXES[axis].rate): lag.value
            for axis, lag in self.all_lags.items()
            if lag.value > 0.0
        }
        structure = Structure(
            rates(self.axes), rates(self.driven), tuple(rows.values()), True,
            tuple((a, b) for a, star, b in (name.partition("*") for name in mass) if star),
            tuple(lags),
            {name: value if "*" in name else float(np.log(value)) for name, value in mass.items()},
            shift_priors=dict.fromkeys(delays, NO_PRIOR),
            channels=(*measured, *(("roll", "pitch") if self._tilts else ())),
        )  # fmt: skip
        theta = {row.key: self.terms[each].value for each, row in rows.items()}
        theta |= {f"{kind}:{rate}": float(np.log(lag)) for (kind, rate), lag in lags.items()}
        return structure, theta | {f"shift:{rate}": delay for rate, delay in delays.items()}

    def acting(self, effort: Stream, axis: str) -> Stream:
        """An effort after the static stages of the axis's thrust."""
        time, values = effort
        stage, full = static_stage({name: parameter.value for name, parameter in self.thrust.get(axis, {}).items()})
        return time, stage.static(values, full)

    def free_run(self, log: Streams, step: float | None = None, held: bool = False) -> tuple[Array, Array]:
        """Edges (n,) [s] and ν on them (n, 6), from the log's first velocities, or from rest, under its efforts.

        Args:
            log: streams by the names of recordings, of which the velocities and angles may be left out.
            step: between two edges [s]; None for the shortest usual time between two samples.
            held: whether each effort is constant until its next sample; else its values show it.
        """
        used = {name: log[name] for name in (*rates(self.axes), *self._efforts) if name in log}
        begin, end = max(t[0] for t, _ in used.values()), min(t[-1] for t, _ in used.values())
        if step is None:
            step = min(float(np.median(np.diff(t))) for t, _ in used.values())
        edges = begin + step * np.arange(int((end - begin) / step + 1e-6) + 1)
        still, first = (edges, np.zeros(edges.size)), edges[0]
        run = {name: self.acting(log.get(name, still), of_effort) for name, of_effort in self._efforts.items()}
        starts = [float(np.interp(first, *log[rate])) if rate in log else 0.0 for rate in rates(self.axes)]
        structure, theta = self.equation()
        run |= dict.fromkeys(structure.axes, still) | {name: log.get(name, still) for name in structure.channels}
        ways = {axis: "hold" if held or is_held(run[effort_of(axis)][1]) else "linear" for axis in structure.driven}
        structure = replace(structure, ways=ways)
        windows = cut([run], structure, step / np.ceil(max(STEPS_A_DECAY * step * self.decay, 1.0)), np.inf)
        column = np.array([theta[name] for name in structure.names])[:, None]
        predicted = predict(structure, column, windows, np.array(starts)[:, None, None])[:, 0]
        found = np.zeros((edges.size, 6))
        found[0, self.rows] = starts
        found[1:, self.rows] = predicted.reshape(len(self.axes), -1).T
        return edges, found

    @property
    def _efforts(self) -> dict[str, str]:
        """The columns of the efforts that act, and their axes."""
        return {AXES[axis].effort: axis for axis in self.driven}

    @property
    def _tilts(self) -> bool:
        """Whether roll and pitch matter."""
        return any(each.kind in (RIGHTING, WEIGHT) for each in self.terms)

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
            **({"thrust": self._thrust()} if self.thrust else {}),
            "fastest": dict(zip(AXES, (float(value) for value in self.fastest), strict=True)),
            "doubts": list(self.doubts),
            **({"beaten_by": self.beaten_by} if self.beaten_by else {}),
        }

    def _thrust(self) -> dict[str, dict[str, Any]]:
        return {axis: {name: p.to_dict() for name, p in of.items()} for axis, of in self.thrust.items()}

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
        thrust = {
            axis: {name: Parameter.of(parameter) for name, parameter in of.items()}
            for axis, of in data.get("thrust", {}).items()
        }
        axes, driven = _axes(data["axes"]), _axes(data["driven"])
        return Vehicle(
            data["name"], axes, driven, mass, terms, lags, fastest, doubts, thrust, data.get("beaten_by", "")
        )


def beaten(by: str) -> tuple[str, ...]:
    """A sentence on what predicts unseen data better than a model, by its name; none where it is a model."""
    what = {"zero": "a velocity of zero", "hold": "the first velocity kept"}.get(by)
    if what is None:
        return ()
    return (f"{what} predicts unseen data better than this model: record steps of every effort to both sides",)


def _signals(row: Row) -> set[str]:
    """What a row reads."""
    return {factor.of for part in row.parts for factor in (part.one, part.other)}


def _axes(names: Sequence[str]) -> tuple[str, ...]:
    return tuple(name for name in AXES if name in set(names))


def _pair(key: str) -> tuple[str, str]:
    one, _, other = key.partition(",")
    return one, other
