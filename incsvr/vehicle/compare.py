"""Whether a vehicle has changed between dives: its coefficients dive by dive, and a test that holds its level over all.

One structure is chosen on all dives together; each dive then gives its own inertias and drags with standard errors,
and `changes` tests them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import t as student

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from incsvr.plant.terms import LINEAR, QUADRATIC
from incsvr.vehicle.changes import changes
from incsvr.vehicle.fitting import Fit, fit
from incsvr.vehicle.held_out import spread_windows
from incsvr.vehicle.identify import Identified, identify
from incsvr.vehicle.intervals import Scatter
from incsvr.vehicle.model import ASSUMED, DECLARED
from incsvr.vehicle.motion import WholeMotion, joined
from incsvr.vehicle.scales import Scales
from incsvr.vehicle.shown import Shown, not_determined, places, unit_of
from incsvr.vehicle.structure import Pair, Structure

USUAL_SPEED = 1.5
"""Speed at which drags are compared, in RMS speeds of all dives: linear and quadratic coefficients trade off against
each other, their sum there does not."""


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

    @staticmethod
    def of(motion: WholeMotion) -> Conditions:
        """Those of a motion."""
        speed, effort = (np.sqrt(np.mean(each**2, axis=0)).tolist() for each in (motion.velocity, motion.effort))
        return Conditions(motion.seconds, tuple(speed), tuple(effort))


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


def compare(
    dives: Sequence[WholeMotion], names: Sequence[str], declared: Mapping[Pair, float] | None = None
) -> Comparison:
    """The dives of one vehicle, compared in their order.

    Args:
        dives: motions on one grid.
        names: what they are called.
        declared: entries of M that are known.

    Raises:
        BadInput: fewer than two dives, or one that is too short.
    """
    if len(dives) < 2:
        raise BadInput("comparing needs at least two dives; give more recordings")
    declared = {} if declared is None else declared
    whole = joined(dives)
    identified = identify(whole, None, declared, validate=False)
    vehicle = identified.vehicle
    structure, start = vehicle.structure, vehicle.parameters
    known = [k for k, parameter in enumerate(vehicle.mass.values()) if parameter.origin in (DECLARED, ASSUMED)]
    scales = Scales.of(whole, {one: value for (one, other), value in declared.items() if one == other})
    quantities = _quantities(structure, whole, known)
    found = []
    for name, dive in zip(names, dives, strict=True):
        windows = spread_windows(dive)
        if windows.first.size < structure.size + 2:
            raise BadInput(
                f"{name}: {dive.seconds:.3g} s are too short to fit {structure.size} parameters; leave it out"
            )
        low, high = (bound.copy() for bound in scales.bounds(structure))
        for k in known:
            low[k] = high[k] = start[k]
        fitted = fit(windows, structure, start, np.maximum(np.abs(start), scales.start(structure)[1]), (low, high))
        found.append(_measured(fitted, quantities, np.clip(fitted.parameters, low, high)))
    values = _values(np.stack(found, axis=1))
    conditions = tuple(Conditions.of(dive) for dive in dives)
    return Comparison(tuple(names), conditions, quantities, tuple(values), identified)


def _quantities(structure: Structure, motion: WholeMotion, known: Sequence[int]) -> tuple[Quantity, ...]:
    """The inertia and the drag of each axis."""
    speed = np.sqrt(np.mean(motion.velocity**2, axis=0))
    inertias = [
        Quantity(one, "inertia") for k, (one, other) in enumerate(structure.mass) if one == other and k not in known
    ]
    drags = [Quantity(axis, "drag", USUAL_SPEED * float(speed[list(AXES).index(axis)])) for axis in structure.axes]
    return (*inertias, *drags)


def _measured(fitted: Fit, quantities: Sequence[Quantity], parameters: Array) -> Array:
    """Estimate, standard error and degrees of freedom of each quantity, (quantities, 3): linear in the parameters.

    An error is at least what it would be if all windows erred alike, because that of a short dive can be small by
    chance.
    """
    structure, scatter = fitted.structure, Scatter.of(fitted)
    along = np.zeros((len(quantities), structure.size))
    first = len(structure.mass)
    for row, quantity in zip(along, quantities, strict=True):
        if quantity.kind == "inertia":
            row[structure.mass.index((quantity.axis, quantity.axis))] = 1.0
        for k, term in enumerate(structure.terms):
            if quantity.kind == "drag" and term.axis == quantity.axis and term.kind in (LINEAR, QUADRATIC):
                row[first + k] = quantity.speed ** (1 if term.kind == LINEAR else 2)
    errors = np.maximum(scatter.errors(along), scatter.errors_if_alike(along))
    return np.column_stack([along @ parameters, errors, scatter.freedom(along)])


def _values(rows: Array) -> list[tuple[Value, ...]]:
    """The values of each quantity dive by dive, from estimates, standard errors and degrees of freedom
    (quantities, dives, 3)."""
    estimate, error, freedom = np.moveaxis(rows, 2, 0)
    reach = student.ppf(0.975, freedom) * error
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
