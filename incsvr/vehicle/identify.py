"""The identification of a whole vehicle's model from its motion: M, C(ν) ν, damping, couplings and lags.

1. Every axis whose velocity is recorded is modelled. The inertia of one without actuators follows from the Coriolis
   forces on it, or is assumed.
2. All parameters that a hull may have are fitted together to predictions over the shortest time scale of the motion.
3. Couplings that parts of the data left out do not need are taken out; rarer terms and lags are added where they pay.
4. Intervals come from the scatter between blocks; a parameter whose interval is wider than the axis's usual effort is
   called not excited, an inertia at the edge of its search bound reached, with the manoeuvre that would show it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.coefficients import COEFFICIENT_NAMES
from incsvr.plant.axes import AXES
from incsvr.plant.terms import LINEAR, PRODUCT, QUADRATIC, Term, couplings, extras, own_damping, restoring
from incsvr.vehicle.current import suspected_current
from incsvr.vehicle.fitting import Fit, Windows, fit_from_afar
from incsvr.vehicle.held_out import NO_VALIDATION, spread_windows, validated
from incsvr.vehicle.intervals import intervals
from incsvr.vehicle.manoeuvres import divergences, manoeuvres
from incsvr.vehicle.model import ASSUMED, BOUND_REACHED, DECLARED, ESTIMATED, UNKNOWN, Parameter, Vehicle
from incsvr.vehicle.motion import WholeMotion
from incsvr.vehicle.scales import Candidate, Scales
from incsvr.vehicle.selection import MIN_EVIDENCE, LeftOut, extended, parts, reduced
from incsvr.vehicle.structure import Pair, Structure, coupled_pairs
from incsvr.vehicle.validation import Course, Errors

STEPS = 4
"""Steps of an identification beside one for each axis by itself: fit, leave out, add, predict unseen data."""
MIN_WINDOWS_A_PARAMETER = 2.0
"""Windows of which there must be so many for each parameter: fewer can be fitted by anything."""


@dataclass(frozen=True, slots=True)
class Identified:
    """A whole vehicle, identified.

    Attributes:
        vehicle: its model.
        refusals: axis → why it is not in the model.
        manoeuvres: what would show the parameters that are not excited, one sentence each.
        errors: of predictions of unseen data: other recordings, or each part of these by the others.
        by_itself: axis → the same of that axis alone, the other velocities as measured.
        seconds: length of the data that were fitted [s].
        step: length of a cell [s].
        unseen: whether `errors` are of other recordings.
        course: a free run on unseen data: the longest of the other recordings, or of the last part; None where the
            errors are of nothing.
        warnings: why predictions or intervals do not hold, and the cure, one sentence each.
    """

    vehicle: Vehicle
    refusals: Mapping[str, str]
    manoeuvres: tuple[str, ...]
    errors: Errors
    by_itself: Mapping[str, Errors]
    seconds: float
    step: float
    unseen: bool
    course: Course | None = None
    warnings: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """The result as plain data: each axis, the mass matrix, the errors of free runs, and the vehicle file."""
        vehicle = self.vehicle.to_dict()
        return {
            "axes": {axis: self._axis(axis) for axis in self.vehicle.axes}
            | {axis: {"identified": False, "reason": why} for axis, why in self.refusals.items()},
            "mass_matrix": vehicle["mass_matrix"],
            "free_run": {
                "on": "other recordings" if self.unseen else "parts of the recordings, each predicted by the others",
                **self.errors.to_dict(),
            },
            "manoeuvres": list(self.manoeuvres),
            "warnings": list(self.warnings),
            "seconds": self.seconds,
            "step_s": self.step,
            "vehicle": vehicle,
        }

    def _axis(self, axis: str) -> dict[str, Any]:
        """One identified axis: its inertia, the coefficients under the names of `incsvr fit`, and its errors alone."""
        terms, by_itself = self.vehicle.terms, self.by_itself.get(axis)
        coefficients = {
            name: terms.get(Term(axis, kind)) for name, kind in zip(COEFFICIENT_NAMES, (LINEAR, QUADRATIC), strict=True)
        }
        inertia = self.vehicle.mass.get((axis, axis))
        return {
            "identified": True,
            "inertia": None if inertia is None else inertia.value,
            "coefficients": {
                name: {"estimate": p.value, "low": p.low, "high": p.high} for name, p in coefficients.items() if p
            },
            "by_itself": None if by_itself is None else by_itself.to_dict(),
        }


def identify(
    motion: WholeMotion,
    unseen: WholeMotion | None = None,
    declared: Mapping[Pair, float] | None = None,
    name: str = "vehicle",
    validate: bool = True,
    begins: Callable[[str], None] = lambda step: None,
) -> Identified:
    """The model of the vehicle that moved so.

    Args:
        motion: recorded runs.
        unseen: runs for the errors alone, on the same grid.
        declared: entries of M that are known [kg], [kg m], [kg m²], by the names of both axes.
        name: as people call the vehicle.
        validate: whether the errors of predictions are asked for; else they are those of nothing.
        begins: callback that is given each step as it begins, `STEPS` of them and one for each axis.

    Raises:
        BadInput: nothing drives the vehicle, or the recordings are too short; with the cure.
    """
    declared = {} if declared is None else declared
    driven = _driven(motion)
    scales = Scales.of(motion, {one: value for (one, other), value in declared.items() if one == other})
    windows = spread_windows(motion)
    fitted = _fitted(windows, driven, declared, scales, begins)
    vehicle = _vehicle(name, driven, motion, fitted, scales, declared)
    found = validated(windows, unseen, fitted, scales, begins) if validate else NO_VALIDATION
    current = suspected_current(windows, fitted)
    advice = manoeuvres(vehicle)
    warnings = (*(() if current is None else (current.warning,)), *divergences(found.errors, driven))
    return Identified(
        replace(vehicle, doubts=(*advice, *warnings)),
        _refusals(motion),
        advice,
        found.errors,
        found.by_itself,
        motion.seconds,
        motion.step,
        validate and unseen is not None,
        found.course,
        warnings,
    )


def _driven(motion: WholeMotion) -> tuple[str, ...]:
    """The recorded axes along which actuators work."""
    driven = tuple(axis.name for axis in AXES.values() if axis.name in motion.axes and _drives(motion, axis.name))
    if not driven:
        raise BadInput(
            "no effort acts along any recorded velocity; name the forces and moments of the thrusters: "
            "--column surge_force=NAME --column torque=NAME"
        )
    return driven


def _fitted(
    windows: Windows,
    driven: tuple[str, ...],
    declared: Mapping[Pair, float],
    scales: Scales,
    begins: Callable[[str], None],
) -> Fit:
    """The model of all axes together, with the parameters that unseen parts of the data need."""
    motion = windows.motion
    axes = motion.axes
    choices = (True, False) if set(axes) - set(driven) else (True,)
    structures = [_whole(driven, motion, declared, scales, tied) for tied in choices]
    _check_length(windows, structures[0])
    begins("fitting all axes together")
    fits = [fit_from_afar(windows, each, *scales.start(each), scales.bounds(each)) for each in structures]
    fitted = _best(fits, windows, scales)
    begins("leaving out what unseen parts do not need")
    fitted = reduced(windows, fitted, scales)
    begins("adding what predicts unseen parts better")
    candidates: list[Candidate] = [*extras(axes, driven, motion.recorded), *driven]
    return extended(windows, fitted, candidates, scales)


def _check_length(windows: Windows, structure: Structure) -> None:
    """Refuses recordings that are too short for so many parameters."""
    motion = windows.motion
    if windows.first.size < MIN_WINDOWS_A_PARAMETER * structure.size:
        # No length is named: longer recordings show slower motion, for which windows are longer.
        axes = f"{len(motion.axes)} axes" if len(motion.axes) > 1 else "one axis"
        raise BadInput(
            f"the recordings hold {motion.seconds:.3g} s of motion, too little for {structure.size} parameters of "
            f"{axes}: give longer or more recordings, in which every effort changes often"
        )


def _refusals(motion: WholeMotion) -> dict[str, str]:
    """The axes that cannot be modelled, and why."""
    return {
        axis.name: f"no {axis.rate} was recorded; record it, or name its column: --column {axis.rate}=NAME"
        for axis in AXES.values()
        if axis.name not in motion.axes
    }


def _drives(motion: WholeMotion, axis: str) -> bool:
    """Whether the effort along an axis is recorded and moves."""
    return AXES[axis].effort in motion.recorded and bool(np.ptp(motion.effort[:, list(AXES).index(axis)]) > 0.0)


def _whole(
    driven: tuple[str, ...],
    motion: WholeMotion,
    declared: Mapping[Pair, float],
    scales: Scales,
    tied: bool,
) -> Structure:
    """Everything that a hull may have.

    Args:
        tied: whether the inertia of an axis without actuators is told from the Coriolis forces on it, which follow from
            the other axes' inertia; else it is assumed, and the products of velocities are free.
    """
    axes = motion.axes
    passive = [name for name in axes if name not in driven and (name, name) not in declared]
    fixed = np.zeros((6, 6))
    names = list(AXES)
    for k, name in enumerate(names):
        fixed[k, k] = 1.0 if name not in axes else 0.0 if name in driven or tied else scales.inertia[k]
    for (one, other), value in declared.items():
        row, column = names.index(one), names.index(other)
        fixed[row, column] = fixed[column, row] = value
    estimated = [(name, name) for name in axes if (name, name) not in declared and (tied or name in driven)]
    # Where a whole matrix is declared, what it leaves zero is zero.
    pairs = [pair for pair in coupled_pairs(axes) if pair not in declared and not set(axes) <= {a for a, _ in declared}]
    terms = (*own_damping(axes), *restoring(axes, motion.recorded), *couplings(axes, driven, motion.recorded))
    if tied:
        terms = tuple(term for term in terms if not (term.axis in passive and _scales_with_inertia(term)))
    return Structure(axes, (*estimated, *pairs), terms, (), fixed)


def _scales_with_inertia(term: Term) -> bool:
    """Whether the term is one of the Coriolis forces along its axis, which would take the place of its inertia."""
    return term.kind == PRODUCT and set(term.of) in [set(pair) for pair in AXES[term.axis].products]


def _best(fits: list[Fit], windows: Windows, scales: Scales) -> Fit:
    """The one that predicts the parts left out best; the first where they are alike."""
    folds = parts(windows)
    variance = fits[0].variance
    loss = [float(LeftOut.of(each, folds, scales).losses(variance).sum()) for each in fits]
    best = int(np.argmin(loss))
    return fits[best] if loss[best] < loss[0] - MIN_EVIDENCE else fits[0]


def _vehicle(
    name: str,
    driven: tuple[str, ...],
    motion: WholeMotion,
    fitted: Fit,
    scales: Scales,
    declared: Mapping[Pair, float],
) -> Vehicle:
    """The model with its intervals."""
    axes, structure = motion.axes, fitted.structure
    bounds = scales.bounds(structure)
    low, high = intervals(fitted, bounds)
    values = np.clip(fitted.parameters, *bounds)
    at_end = np.isclose(values, bounds[0]) | np.isclose(values, bounds[1])
    at_end[len(structure.mass) :] = False  # the bound of damping is zero, which a hull may have
    excited = high - low < 2.0 * np.maximum(fitted.scale, np.abs(values))
    origins = np.where(at_end, BOUND_REACHED, np.where(excited, ESTIMATED, UNKNOWN))
    rows = zip(values.tolist(), low.tolist(), high.tolist(), origins.tolist(), strict=True)
    parameters = [Parameter(*row) for row in rows]
    mass = dict(zip(structure.mass, parameters, strict=False))
    known = {pair: Parameter(value, value, value, DECLARED) for pair, value in declared.items()}
    for k, axis in enumerate(AXES):
        if axis in axes and (axis, axis) not in mass and (axis, axis) not in known:
            value = float(structure.fixed[k, k])
            known[axis, axis] = Parameter(value, value, value, ASSUMED)
    first = len(structure.mass)
    terms = dict(zip(structure.terms, parameters[first:], strict=False))
    lags = dict(zip(structure.lags, parameters[first + len(structure.terms) :], strict=True))
    fastest = np.abs(motion.velocity).max(axis=0)
    return Vehicle(name, axes, driven, {**mass, **known}, terms, lags, fastest)
