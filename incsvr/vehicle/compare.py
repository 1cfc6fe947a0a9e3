"""Whether a vehicle has changed between dives: its coefficients dive by dive, and a test that holds its level over all.

One structure is chosen on all dives together; each dive then gives its own inertias and drags with standard errors,
and `changes` tests them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import stdtrit

from incsvr.errors import BadInput
from incsvr.model.fitting import Fit, Problem, fit
from incsvr.model.intervals import covariance, if_independent
from incsvr.model.left_out import blocks
from incsvr.model.scales import time_constants
from incsvr.model.series import duration, values
from incsvr.model.windows import cut
from incsvr.numerics import Array, Streams, root_mean_square
from incsvr.plant.axes import AXES, EFFORTS, VELOCITIES, of_rate
from incsvr.vehicle.changes import changes, determined
from incsvr.vehicle.identify import Identified, identify
from incsvr.vehicle.model import ASSUMED, DECLARED
from incsvr.vehicle.of_fit import Pair
from incsvr.vehicle.runs import prepared, usual
from incsvr.vehicle.shown import Shown, not_determined, places, unit_of

USUAL_SPEED = 1.5
"""Speed at which drags are compared, in RMS speeds of all dives: linear and quadratic coefficients trade off against
each other, their sum there does not."""

MIN_WINDOWS = 16
"""Windows of a dive at least: a deviation over sixteen is right within a fifth."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity that is compared between dives.

    Attributes:
        axis: its name.
        kind: "inertia", or "drag" at `speed`.
        speed: at which the drag is taken [m/s] or [rad/s]; 0 of an inertia.
    """

    axis: str
    kind: str
    speed: float = 0.0

    @property
    def name(self) -> str:
        """For people, such as "surge drag at 1.2 m/s"."""
        at = f" at {self.speed:.3g} {'m/s' if AXES[self.axis].along else 'rad/s'}" if self.kind == "drag" else ""
        return f"{self.axis} {self.kind}{at}"

    @property
    def unit(self) -> str:
        """The unit of its values."""
        return unit_of(self.axis, self.kind)


@dataclass(frozen=True, slots=True)
class Value:
    """A quantity in one dive.

    Attributes:
        estimate, error: value and standard error, in its unit.
        freedom: degrees of freedom of the error.
        low, high: its interval of 95 %.
        reference: mean of the dives since the last change; None of the first of them.
        reference_error: its standard error; None of the first.
        p_value: of no change against that mean; None of the first.
        changed: whether the test says that it changed in this dive.
        smallest: the smallest difference from that mean that the test would have called a change; None of the first.
    """

    estimate: float
    error: float
    freedom: float
    low: float
    high: float
    reference: float | None
    reference_error: float | None
    p_value: float | None
    changed: bool
    smallest: float | None = None

    @property
    def determined(self) -> bool:
        """Whether it is known at all: it is positive, and its interval is no wider than itself."""
        return self.high - self.low <= self.estimate


@dataclass(frozen=True, slots=True)
class Conditions:
    """How a dive went.

    Attributes:
        seconds: length of its motion [s].
        speed, effort: (6,) RMS velocities [m/s], [rad/s] and efforts [N], [N m] of all axes.
    """

    seconds: float
    speed: tuple[float, ...]
    effort: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Comparison:
    """Dives compared.

    Attributes:
        dives: their names, in order.
        conditions: how each went.
        quantities: what is compared.
        values: (quantities, dives).
        identified: the model of all dives together.
        order: what the order of the dives is, in words.
    """

    dives: tuple[str, ...]
    conditions: tuple[Conditions, ...]
    quantities: tuple[Quantity, ...]
    values: tuple[tuple[Value, ...], ...]
    identified: Identified
    order: str = ""

    @property
    def shown(self) -> tuple[Shown, ...]:
        """The smallest change of each quantity that would have been seen."""
        return tuple(self._shown(*each) for each in zip(self.quantities, self.values, strict=True))

    def _shown(self, quantity: Quantity, row: Sequence[Value]) -> Shown:
        known = np.array([value.determined for value in row])
        smallest = np.array([np.nan if value.smallest is None else value.smallest for value in row])
        (best,) = places(np.zeros(known.size, dtype=np.intp), smallest, known).tolist()
        if best >= 0:
            change, before = row[best].smallest, row[best].reference
            return Shown(quantity.name, quantity.unit, self.dives[best], change, before)
        why = f"{quantity.axis} has no actuator"
        if quantity.axis in self.identified.vehicle.driven:
            cure = f"change the {quantity.axis} effort in steps, each held until the speed settles"
            why = f"{not_determined(int(known.sum()), known.size)}; {cure}"
        return Shown(quantity.name, quantity.unit, why=why)

    @property
    def changes(self) -> list[tuple[str, Quantity, Value]]:
        """Dive, quantity and value of each change that was found."""
        return [
            (dive, quantity, value)
            for quantity, row in zip(self.quantities, self.values, strict=True)
            for dive, value in zip(self.dives, row, strict=True)
            if value.changed
        ]

    def rows(self) -> list[dict[str, Any]]:
        """One row a dive and quantity, for tables."""
        return [
            {
                "dive": dive, "axis": quantity.axis, "quantity": quantity.kind, "at_speed": quantity.speed,
                "unit": quantity.unit, "estimate": value.estimate, "standard_error": value.error,
                "degrees_of_freedom": value.freedom, "low": value.low, "high": value.high,
                "reference": value.reference, "p_value": value.p_value, "changed": value.changed,
                "smallest_change": value.smallest, "determined": value.determined,
                "seconds": went.seconds, "rms_speed": went.speed[list(AXES).index(quantity.axis)],
                "rms_effort": went.effort[list(AXES).index(quantity.axis)],
            }
            for quantity, row in zip(self.quantities, self.values, strict=True)
            for dive, went, value in zip(self.dives, self.conditions, row, strict=True)
        ]  # fmt: skip


def compare(dives: Sequence[Streams], names: Sequence[str], declared: Mapping[Pair, float] | None = None) -> Comparison:
    """The dives of one vehicle, compared in their order.

    Args:
        dives: streams of each by the names of recordings.
        names: what they are called.
        declared: entries of M that are known.

    Raises:
        BadInput: fewer than two dives, or one that is too short.
    """
    if len(dives) < 2:
        raise BadInput("comparing needs at least two dives; give more recordings")
    identified = identify(dives, None, declared, validate=False)
    model, mass = identified.fit, identified.vehicle.mass
    known = [rate for rate in model.structure.axes if mass[(of_rate(rate).name,) * 2].origin in (DECLARED, ASSUMED)]
    known_masses = {rate: float(np.log(model.structure.inertia(model.theta, rate))) for rate in known}
    structure = replace(model.structure, given={**model.structure.given, **known_masses})
    quantities = _quantities(model, known)
    windows, found, conditions = model.problem.windows, [], []
    common = set.intersection(*(set(run) for run in prepared(dives)))
    for name, dive in zip(names, dives, strict=True):
        runs = prepared([{each: stream for each, stream in dive.items() if each in common}])
        seconds = duration(runs, structure.axes[0])
        own = cut(runs, structure, windows.step, min(windows.steps * windows.step, seconds / MIN_WINDOWS))
        fitted = fit(structure, model.theta, Problem(own))
        if own.measured.size < 10 * len(structure.names) or own.first.size < MIN_WINDOWS - 1:
            raise BadInput(
                f"{name}: {seconds:.3g} s are too short to fit {len(structure.names)} parameters; leave it out"
            )
        found.append(_measured(fitted, quantities))
        moved = {each: (np.zeros(1), values(runs, each)) for each in runs[0]}
        conditions.append(Conditions(seconds, usual(moved, VELOCITIES), usual(moved, EFFORTS)))
    rows = _values(_scaled(np.stack(found, axis=1)))
    return Comparison(tuple(names), tuple(conditions), quantities, tuple(rows), identified)


def _quantities(model: Fit, known: Sequence[str]) -> tuple[Quantity, ...]:
    """The inertia and the drag of each axis."""
    structure, runs = model.structure, model.problem.windows.runs
    inertias = [Quantity(of_rate(rate).name, "inertia") for rate in structure.axes if rate not in known]
    drags = [
        Quantity(of_rate(rate).name, "drag", USUAL_SPEED * root_mean_square(values(runs, rate)))
        for rate in structure.axes
    ]
    return (*inertias, *drags)


def _measured(fitted: Fit, quantities: Sequence[Quantity]) -> Array:
    """Estimate, standard error and degrees of freedom of each quantity, and half of what the dive's halves differ by,
    (quantities, 4).

    The degrees are Satterthwaite's, from each block's part in the variance. A deviation is at least what errors that
    last as long as these would give, because that over few blocks can be small by chance. An axis that settles
    within a step determines nothing.
    """
    spread, units, found = covariance(fitted), fitted.units, []
    windows, lasts = fitted.problem.windows, _lasting(fitted)
    settles = time_constants(fitted.structure, fitted.theta, windows.runs, 0.95)
    inverse = if_independent(fitted)
    block, between = blocks(fitted.problem.windows), _between_halves(fitted)
    for quantity in quantities:
        rate, along, estimate = AXES[quantity.axis].rate, np.zeros(len(fitted.names)), 0.0
        if quantity.kind == "inertia":
            estimate = fitted.structure.inertia(fitted.theta, rate)
            along[fitted.names.index(f"mass:{rate}")] = estimate  # its logarithm is in θ
        for row in fitted.structure.rows if quantity.kind == "drag" else ():
            power = {"linear": 1, "quadratic": 2}.get(row.name)
            if power and row.axis == rate:
                along[fitted.names.index(row.key)] = quantity.speed**power
                estimate += fitted.theta[row.key] * quantity.speed**power
        pull = inverse @ (along * units)
        shares = np.bincount(block, np.einsum("p,wpq,q->w", pull, fitted.normal, pull))
        freedom = np.clip(shares.sum() ** 2 / max(float(np.sum(shares**2)), 1e-300), 1.0, max(shares.size - 1.0, 1.0))
        variance = max(float(along @ spread @ along), lasts * float((along * units) @ pull))
        least = estimate if settles[fitted.structure.axes.index(rate)] < windows.step else 0.0
        found.append((estimate, max(float(np.sqrt(variance)), least), float(freedom), float(along @ between)))
    return np.array(found)


def _between_halves(fitted: Fit) -> Array:
    """(p,) half of what θ of both halves of a dive differs by, each half a step of the whole fit away."""
    first, whole, steps = np.arange(fitted.cost.size) < fitted.cost.size // 2, fitted.normal.sum(axis=0), []
    for own in (first, ~first):
        part = fitted.normal[own].sum(axis=0) + np.diag(fitted.prior + 0.01 * np.diag(whole))
        steps.append(np.linalg.lstsq(part, fitted.gradient[own].sum(axis=0), rcond=1e-10)[0])
    return np.asarray(0.5 * (steps[0] - steps[1]) * fitted.units)


def _scaled(rows: Array) -> Array:
    """(quantities, dives, 3) with standard errors as much larger as the halves of the dives differ by more than these
    say, over all that is determined: water, payload and trim vary within a dive as between unchanged ones."""
    estimate, error, freedom, half = np.moveaxis(rows, 2, 0)
    known = determined(estimate, error, freedom)
    excess = float(np.mean((half / error)[known] ** 2)) if known.any() else 1.0
    return np.stack([estimate, error * np.sqrt(max(1.0, excess)), freedom], axis=2)


def _lasting(fitted: Fit) -> float:
    """Samples that a fit's errors last: one and twice the sum of their autocorrelation, of the axis with the most."""
    windows, most = fitted.problem.windows, 1.0
    for i in range(len(windows.axes)):
        own = windows.axis == i
        error, window, total = np.clip(fitted.error[own] / fitted.scale[i], -4.0, 4.0), windows.window[own], 1.0
        for lag in range(1, error.size // windows.first.size):
            together = window[lag:] == window[:-lag]
            share = float(np.sum((error[lag:] * error[:-lag])[together]) / np.sum(error**2))
            if share <= 0.05:
                break
            total += 2.0 * share
        most = max(most, total)
    return most


def _values(rows: Array) -> list[tuple[Value, ...]]:
    """The values of each quantity dive by dive, from estimates, standard errors and degrees of freedom
    (quantities, dives, 3)."""
    estimate, error, freedom = np.moveaxis(rows, 2, 0)
    reach = stdtrit(freedom, 0.975) * error
    found = changes(estimate, error, freedom, np.full(rows.shape[0], 1.0 / rows.shape[0]))
    ends = [freedom, estimate - reach, estimate + reach]
    columns = np.stack(
        [estimate, error, *ends, found.reference, found.reference_error, found.p_value, found.smallest], axis=2
    )
    return [
        tuple(_value(each, flag) for each, flag in zip(row, flags, strict=True))
        for row, flags in zip(columns.tolist(), found.changed.tolist(), strict=True)
    ]


def _value(numbers: list[float], changed: bool) -> Value:
    """The value of its numbers in their order, with none for what is no number."""
    estimate, error, freedom, low, high = numbers[:5]
    reference, reference_error, p_value, smallest = (None if np.isnan(each) else each for each in numbers[5:])
    return Value(estimate, error, freedom, low, high, reference, reference_error, p_value, changed, smallest)
