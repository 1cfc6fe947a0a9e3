"""The engine's fit as a vehicle: entries of M, terms and thrust with their intervals and origins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from incsvr.model.fitting import Fit
from incsvr.model.intervals import Interval
from incsvr.model.series import effort_of, period
from incsvr.model.structure import is_logarithm
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, VELOCITIES, of_rate
from incsvr.plant.mass_and_coriolis import PAIRS, product_weights
from incsvr.plant.terms import PRODUCT, REVERSE, SQUARE, Term
from incsvr.vehicle.equation import FULL, STAGES, pair_of, terms_of
from incsvr.vehicle.model import ASSUMED, DECLARED, ESTIMATED, UNKNOWN, Parameter, Vehicle

Pair = tuple[str, str]
"""Row and column of an entry of M, by the names of their axes; a symmetric entry is named once."""


def vehicle_of(
    name: str, found: Fit, intervals: Mapping[str, Interval], declared: Mapping[Pair, float], fastest: Array
) -> Vehicle:
    """The vehicle of a fit.

    Args:
        intervals: of its parameters.
        declared: entries of M that are known.
        fastest: (6,) fastest velocities.
    """
    structure = found.structure
    mass, terms = dict[Pair, Parameter](), dict[Term, Parameter]()
    parameters = {each: _parameter(found, each, one) for each, one in intervals.items()}
    for axis in structure.axes:
        key, value = pair_of(axis), structure.inertia(found.theta, axis)
        free = axis not in structure.driven and not structure.tied  # any scale would do
        assumed = Parameter(value, value, value, ASSUMED)
        one = assumed if free else parameters.get(f"mass:{axis}", assumed)
        mass[key] = assumed if axis not in structure.driven and one.origin == UNKNOWN else one
    mass |= {
        pair_of(f"mass:{a}*{b}"): parameters[f"mass:{a}*{b}"]
        for a, b in structure.coupled
        if f"mass:{a}*{b}" in parameters
    }
    mass |= {
        pair: Parameter(value, value, value, DECLARED)
        for pair, value in declared.items()
        if {*pair} <= {of_rate(a).name for a in structure.axes}
    }
    for row in structure.rows:
        for each, sign in terms_of(row):
            terms[each] = _plus(terms.get(each), _times(parameters[row.key], sign))
    if not structure.tied and len(structure.axes) > 1:
        for each, parameter in _without_coriolis(mass, structure.axes).items():
            terms[each] = _plus(terms.get(each), parameter)
    assumed_axes = {one for (one, other), each in mass.items() if one == other and each.origin == ASSUMED}
    mass |= {
        pair: replace(each, origin=ASSUMED)
        for pair, each in mass.items()
        if each.origin != DECLARED and assumed_axes & {*pair}
    }
    terms |= {term: replace(each, origin=ASSUMED) for term, each in terms.items() if term.axis in assumed_axes}
    lags, thrust = _stages(found, parameters)
    read = {factor.of for row in structure.rows for part in row.parts for factor in (part.one, part.other)}
    for axis in [axis for axis, of in thrust.items() if set(of) == {"reverse"}]:
        if axis in lags or AXES[axis].effort in read:
            continue
        one = thrust.pop(axis)["reverse"]  # as a term it is the same, for nothing else changes or reads this effort
        terms[Term(axis, REVERSE)] = Parameter(1.0 - one.value, 1.0 - one.high, 1.0 - one.low, one.origin)
    axes, driven = (tuple(of_rate(rate).name for rate in each) for each in (structure.axes, structure.driven))
    return Vehicle(name, axes, driven, mass, terms, lags, fastest, (), thrust)


def _parameter(found: Fit, name: str, one: Interval) -> Parameter:
    """A parameter with its interval, and whether the recordings excite it."""
    unit = abs(one.value) if is_logarithm(name) else float(found.units[found.names.index(name)])
    excited = one.high - one.low < 2.0 * max(unit, abs(one.value))
    return Parameter(one.value, one.low, one.high, ESTIMATED if excited else UNKNOWN)


def _times(one: Parameter, sign: float) -> Parameter:
    return one if sign > 0.0 else Parameter(-one.value, -one.high, -one.low, one.origin)


def _plus(one: Parameter | None, other: Parameter) -> Parameter:
    """Two parts of one coefficient."""
    if one is None:
        return other
    reach = [
        np.hypot(one.value - one.low, other.value - other.low),
        np.hypot(one.high - one.value, other.high - other.value),
    ]
    value = one.value + other.value
    return Parameter(value, value - float(reach[0]), value + float(reach[1]), one.origin)


def _without_coriolis(mass: Mapping[Pair, Parameter], axes: tuple[str, ...]) -> dict[Term, Parameter]:
    """Products that take away C(ν) ν, which in a vehicle file follows from M."""
    names = list(AXES)
    matrices = np.zeros((3, 6, 6))
    for (one, other), p in mass.items():
        row, column = names.index(one), names.index(other)
        matrices[:, row, column] = matrices[:, column, row] = (p.value, p.low, p.high)
    weights, found = -product_weights(matrices), {}
    for row in (list(VELOCITIES).index(axis) for axis in axes):
        for k, (a, b) in enumerate(PAIRS):
            value = weights[0, row, k]
            if abs(value) > 1e-12 * np.abs(matrices[0]).max() and {VELOCITIES[a], VELOCITIES[b]} <= set(axes):
                kind, of = (SQUARE, (VELOCITIES[a],)) if a == b else (PRODUCT, (VELOCITIES[a], VELOCITIES[b]))
                ends = np.sort(weights[:, row, k]).tolist()
                found[Term(names[row], kind, of)] = Parameter(float(value), ends[0], ends[-1])
    return found


def _stages(
    found: Fit, parameters: Mapping[str, Parameter]
) -> tuple[dict[str, Parameter], dict[str, dict[str, Parameter]]]:
    """Lags, and the other stages of the efforts, by axis; a shift within a period is one of the stamps."""
    structure, windows = found.structure, found.problem.windows
    lags, thrust = dict[str, Parameter](), dict[str, dict[str, Parameter]]()
    for axis in structure.driven:
        name, of = of_rate(axis).name, dict[str, Parameter]()
        for kind in (kind for kind, own in structure.stages if own == axis):
            if kind == "lag":
                lags[name] = parameters[f"lag:{axis}"]
            else:
                of[STAGES[kind]] = parameters[f"{kind}:{axis}"]
        if "exponent" in of:
            top = windows.largest(effort_of(axis))
            of[FULL] = Parameter(top, top, top)
        delay = parameters.get(f"shift:{axis}")
        if delay is not None and delay.low > period(windows.runs, effort_of(axis)):
            of["delay_s"] = delay
        if of:
            thrust[name] = of
    return lags, thrust
