"""The declared model, its damping and the effects that it lacked, as one value that is saved and read.

I₀ ṙ + d(r) + Σ effects = τ

An effect is some rows, stages, a dead time or an inertia of the engine, with their values.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from incsvr.model.efforts import Stage
from incsvr.model.factors import one_by_one
from incsvr.model.rows import Factor, Part, Row
from incsvr.model.series import effort_of
from incsvr.model.structure import NO_PRIOR, STAGES, Structure
from incsvr.numerics import Array, Stream
from incsvr.numerics.plain import fields_from_plain, fields_to_plain
from incsvr.plant.axes import YAW

TABLE_RATES = 101
"""Rates of the table to either side."""


@dataclass(frozen=True, slots=True)
class Effect:
    """An effect as it is in a model.

    Attributes:
        name: the contract's.
        theta: its parameters as the engine's θ has them: coefficients of rows, logarithms of time constants and stages,
            a dead time, the logarithm of the whole inertia.
        rows: of the equation of motion.
    """

    name: str
    theta: Mapping[str, float]
    rows: tuple[Row, ...] = ()

    def value(self, kind: str, of: str) -> float | None:
        """A parameter out of its logarithm, such as the `lag` of an axis; None where the effect has none."""
        found = self.theta.get(f"{kind}:{of}")
        return found if found is None or kind == "shift" else math.exp(found)

    @property
    def signals(self) -> tuple[str, ...]:
        """What its rows read beside their memories."""
        read = (each for row in self.rows for part in row.parts for each in (part.one.of, part.other.of, row.follows))
        return tuple(dict.fromkeys(name for name in read if name and not name.startswith("~")))

    def to_dict(self) -> dict[str, Any]:
        return {"effect": self.name, "theta": dict(self.theta), "rows": [_plain(row) for row in self.rows]}

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Effect:
        theta = {str(name): float(value) for name, value in data["theta"].items()}
        found = Effect(str(data["effect"]), theta, tuple(_row(each) for each in data["rows"]))
        keys = {key for row in found.rows for key in (row.key, *([f"time:{row.key}"] if row.follows else []))}
        kinds = {name.partition(":")[0] for name in theta.keys() - keys}
        if not keys <= theta.keys() or not kinds <= {"mass", "shift", *STAGES} or not theta:
            raise ValueError(f"{found.name} has parameters {', '.join(theta)} for rows {', '.join(keys)}")
        return found


@dataclass(frozen=True, slots=True)
class TracedModel:
    """The declared model, its learned damping and the effects that were added.

    Attributes:
        inertia: I₀, as declared [kg m²].
        rate: (m,) increasing rates of the damping table [rad/s]; the trained range.
        damping: (m,) d(r) there [N m].
        effects: in the order in which they were added.
        sigma: deviation of what the model lacks over a block [N m].
        block: the length of such a block [s].
        scale: T_c, the time scale of the vehicle's motion [s].
        origin: first and last stamp of the fitted recordings, to which drifts refer [s].
        axis: the velocity that it predicts.
        top: the effort at which a thrust curve gives what is demanded [N m].
    """

    inertia: float
    rate: Array
    damping: Array
    effects: tuple[Effect, ...]
    sigma: float
    block: float
    scale: float
    origin: tuple[float, float]
    axis: str = YAW.rate
    top: float = 1.0

    @property
    def theta(self) -> dict[str, float]:
        """The parameters of all effects."""
        return {name: value for effect in self.effects for name, value in effect.theta.items()}

    @property
    def whole_inertia(self) -> float:
        """The declared inertia, or the traced one in its place [kg m²]."""
        return math.exp(self.theta.get(f"mass:{self.axis}", math.log(self.inertia)))

    def added_to(self, plain: Structure) -> Structure:
        """A plain structure of the axis with the effects, but for the stages that `acting` has applied; its inertia is
        the traced one."""
        own, theta = {row.key for row in plain.rows}, self.theta
        rows = {row.key: row for effect in self.effects for row in effect.rows if row.key not in own}
        lags = [(kind, self.axis) for kind in ("spin", "lag") if f"{kind}:{self.axis}" in theta]
        more = plain.plus(tuple(rows.values()), lags)
        given = {**plain.given, self.axis: math.log(self.whole_inertia)} if plain.given else plain.given
        late = {self.axis: NO_PRIOR} if f"shift:{self.axis}" in theta else {}
        return replace(more, given=given, shift_priors={**plain.shift_priors, **late})

    def acting(self, effort: Stream) -> Stream:
        """The stamps and values of an effort after the stages that act on its samples."""
        passed = [stage for _, stage in stages(self.effects, self.axis)]
        return effort[0], passed[-1].static(effort[1], self.top) if passed else effort[1]

    def damping_at(self, rate: Array) -> Array:
        """d(r) [N m]; beyond the trained range the edge's drag continues quadratically."""
        inside = np.interp(rate, self.rate, self.damping)
        edge = np.where(rate > 0.0, self.rate[-1], self.rate[0])
        beyond = np.maximum(np.abs(rate / np.where(edge == 0.0, 1.0, edge)), 1.0)
        continued: Array = inside * beyond**2
        return continued

    def to_dict(self) -> dict[str, Any]:
        """Plain data, exact to the last bit through JSON."""
        return fields_to_plain(self)

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> TracedModel:
        """Raises an exception of any kind where it is not what `to_dict` can have given."""
        return fields_from_plain(TracedModel, data)


def stages(effects: Iterable[Effect], axis: str) -> list[tuple[str, Stage]]:
    """Each effect between command and thrust, in the order in which an effort passes them, with all up to it."""
    passed, found = Stage(), list[tuple[str, Stage]]()
    every = list(effects)
    for kind in (*STAGES[:-1], "shift", STAGES[-1]):
        for effect in every:
            value = effect.value(kind, axis)
            if value is not None:
                passed = replace(passed, **{kind: value})
                found.append((effect.name, passed))
    return found


def parts(
    effects: Sequence[Effect], axis: str, signals: Mapping[str, Array], effort: Callable[[Stage], Array]
) -> dict[str, Array]:
    """By effect what it takes of the torque [N m]; an inertia, which takes its part of the acceleration, is not there.

    Args:
        signals: what the rows read, in one shape, memories as `~` and the row's key among them.
        effort: the mean effort of the axis after some stages, in the same shape.
    """
    found = dict[str, Array]()
    acting = effort(Stage())
    for name, stage in stages(effects, axis):
        after = effort(stage)
        found[name], acting = found.get(name, 0.0) + (acting - after), after
    seen = {**signals, effort_of(axis): acting}
    for effect in effects:
        for row in effect.rows:
            part = next(part for part in row.parts if part.axis == axis)
            taken = effect.theta[row.key] * part.sign * one_by_one(part.one, seen) * one_by_one(part.other, seen)
            found[effect.name] = found.get(effect.name, 0.0) + taken
    return found


def _plain(row: Row) -> dict[str, Any]:
    parts = [[part.axis, _factor(part.one), _factor(part.other), part.sign] for part in row.parts]
    return {"name": row.name, "parts": parts, "follows": row.follows}


def _factor(factor: Factor) -> list[Any]:
    return [factor.kind, factor.of, factor.width]


def _row(data: Mapping[str, Any]) -> Row:
    parts = (Part(axis, Factor(*one), Factor(*other), sign) for axis, one, other, sign in data["parts"])
    return Row(data["name"], tuple(parts), follows=data["follows"])
