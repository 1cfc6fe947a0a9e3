"""The identification of a whole vehicle by the engine: M, C(ν) ν, damping, couplings, and what its actuators do.

Every axis whose velocity is recorded is modelled. The inertia of one without actuators follows from the Coriolis forces
on it, or is assumed. A parameter whose interval is wider than the axis's usual effort is called not excited, with the
manoeuvre that would show it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.coefficients import COEFFICIENT_NAMES
from incsvr.model import identification as engine
from incsvr.model.fitting import Fit
from incsvr.model.intervals import Interval, covering, halved, intervals
from incsvr.model.scales import motion_scale, time_constants
from incsvr.model.series import duration, effort_of, period
from incsvr.numerics import Streams
from incsvr.plant.axes import AXES, VELOCITIES, of_rate
from incsvr.plant.terms import LINEAR, QUADRATIC, Term
from incsvr.vehicle.current import suspected_current
from incsvr.vehicle.equation import LEFT, rates
from incsvr.vehicle.manoeuvres import divergences, manoeuvres
from incsvr.vehicle.model import Vehicle, beaten
from incsvr.vehicle.of_fit import Pair, vehicle_of
from incsvr.vehicle.prediction import NO_ERRORS, Course, Errors, alone, errors, unseen_parts
from incsvr.vehicle.runs import axes_of, largest, prepared

STEPS = 3
"""Steps of an identification beside one for each axis by itself: fit, intervals, predict unseen data."""
MIN_SCALES_A_PARAMETER = 2.0
"""Time scales of the motion of which there must be so many for each parameter: fewer can be fitted by anything."""
SURE_SHARE = 0.05
"""Half width of an interval, in the inertia, beyond which coarse samples are named."""
SAMPLES_A_CONSTANT = 10.0
"""Samples in a time constant that show an inertia within 5 %."""


@dataclass(frozen=True, slots=True)
class Identified:
    """A whole vehicle, identified.

    Attributes:
        vehicle: its model.
        fit: the engine's.
        refusals: axis → why it is not in the model.
        manoeuvres: what would show the parameters that are not excited, one sentence each.
        errors: of predictions of unseen data: other recordings, or each part of these by the others.
        by_itself: axis → the same of that axis alone, the other velocities as measured.
        seconds: length of the data that were fitted [s].
        unseen: whether `errors` are of other recordings.
        course: a free run on unseen data: the longest of the other recordings, or of the parts; None where the
            errors are of nothing.
        warnings: why predictions or intervals do not hold, and the cure, one sentence each.
    """

    vehicle: Vehicle
    fit: Fit
    refusals: Mapping[str, str]
    manoeuvres: tuple[str, ...]
    errors: Errors
    by_itself: Mapping[str, Errors]
    seconds: float
    unseen: bool
    course: Course | None = None
    warnings: tuple[str, ...] = ()

    @property
    def step(self) -> float:
        """The step of the simulation [s]."""
        return self.fit.problem.windows.step

    @property
    def effective(self) -> bool:
        """Whether the inertias contain those of axes that move, too, and are not in the recordings."""
        return not {"heave", "roll", "pitch"} <= set(self.vehicle.axes)

    @property
    def best(self) -> dict[str, Any]:
        """The best in free run of the model, each axis by itself, zero and the first velocity kept."""
        found = self.errors
        own = [float(self.by_itself[axis].free_run[0]) for axis in found.axes]
        rivals = {"model": found.free_run.tolist(), "by_itself": own, "zero": found.zero.tolist()}
        rivals["hold"] = found.hold.tolist()
        shares = {name: float(np.mean(each / found.zero)) for name, each in rivals.items()}
        name = min(shares, key=lambda each: shares[each])
        return {"name": name, "free_run_rmse": dict(zip(found.axes, rivals[name], strict=True))}

    @property
    def verdict(self) -> tuple[str, ...]:
        """A sentence where no model is worth its while; none where one is."""
        return beaten(self.best["name"]) if self.errors.axes else ()

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
                **({"best": self.best} if self.errors.axes else {}),
            },
            "verdict": list(self.verdict),
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
    recordings: Sequence[Streams],
    unseen: Sequence[Streams] | None = None,
    declared: Mapping[Pair, float] | None = None,
    name: str = "vehicle",
    validate: bool = True,
    begins: Callable[[str], None] = lambda step: None,
) -> Identified:
    """The model of the vehicle that moved so.

    Args:
        recordings: streams of each run by the names of recordings.
        unseen: runs for the errors alone.
        declared: entries of M that are known [kg], [kg m], [kg m²], by the names of both axes.
        name: as people call the vehicle.
        validate: whether the errors of predictions are asked for; else they are those of nothing.
        begins: callback that is given each step as it begins, `STEPS` of them and one for each axis.

    Raises:
        BadInput: nothing drives the vehicle, or the recordings are too short; with the cure.
    """
    declared = {} if declared is None else declared
    runs = prepared(recordings)
    axes = axes_of(runs)
    given = {"*".join(rates(tuple(dict.fromkeys(pair)))): v for pair, v in declared.items() if {*pair} <= {*axes}}
    _check(runs, axes, given)
    begins("fitting all axes together")
    left = ("thrust_speed",) if len(axes) == 1 and given else ()  # about the usual speed, which a file does not say
    found = engine.identify(runs, rates(axes), given, leave=(*LEFT, *left))
    ours = {each: model for each, model in found.models.items() if not each.endswith("free inertia")}
    best = min(ours, key=lambda each: float(np.mean(found.excluded[each] / found.excluded["zero"])))
    model = ours[best]
    begins("finding intervals")
    coarse = halved(model)
    others = [coarse] + ([found.found.fit] if best == "effects" or not found.found.added else [])
    known = intervals(model, others)
    # Damping between axes passes for inertia where efforts are proportional, and recordings may not exclude it; real
    # lags have neither shape exactly.
    for rival in (engine.crossed(model), engine.reshaped(model)):
        known = covering(known, intervals(rival))
    vehicle = vehicle_of(name, model, known, declared, largest(runs, VELOCITIES))
    judged, course, by_itself = NO_ERRORS, None, dict[str, Errors]()
    if validate:
        begins("predicting unseen data")
        data = None if unseen is None else prepared(unseen)
        step = model.problem.windows.step
        judged, course = errors(model.structure, unseen_parts(model, data), step)
        for axis in axes:
            begins(f"predicting {axis} by itself")
            own = alone(model, AXES[axis].rate)
            by_itself[axis] = errors(own.structure, unseen_parts(own, data), step)[0]
    current = suspected_current(model)
    warnings = (
        *(() if current is None else (current.warning,)),
        *_too_coarse(model, intervals(model, [coarse]), runs),
        *divergences(judged, vehicle.driven),
        *_beside_lags(vehicle),
    )
    advice = manoeuvres(vehicle)
    identified = Identified(
        vehicle, model, _refusals(axes), advice, judged, by_itself, duration(runs, AXES[axes[0]].rate),
        validate and unseen is not None, course, warnings,
    )  # fmt: skip
    doubts = (*identified.verdict, *advice, *warnings)
    beaten_by = identified.best["name"] if identified.verdict else ""
    return replace(identified, vehicle=replace(vehicle, doubts=doubts, beaten_by=beaten_by))


def _check(runs: Sequence[Streams], axes: Sequence[str], given: Mapping[str, float]) -> None:
    """Refuses recordings that nothing drives, or that are too short for so many parameters."""
    structure = engine.structure_of(runs, rates(tuple(axes)), (), given)
    if not structure.driven:
        raise BadInput(
            "no effort acts along any recorded velocity; name the forces and moments of the thrusters: "
            "--column surge_force=NAME --column torque=NAME"
        )
    count = len([each for each in structure.names if not each.startswith("shift:")])
    seconds = duration(runs, structure.axes[0])
    if seconds < MIN_SCALES_A_PARAMETER * count * min(motion_scale(runs, axis) for axis in structure.axes):
        # No length is named: longer recordings show slower motion, which has longer time scales.
        named = f"{len(axes)} axes" if len(axes) > 1 else "one axis"
        raise BadInput(
            f"the recordings hold {seconds:.3g} s of motion, too little for {count} parameters of {named}: give longer "
            "or more recordings, in which every effort changes often"
        )


def _refusals(axes: Sequence[str]) -> dict[str, str]:
    """The axes that cannot be modelled, and why."""
    return {
        axis.name: f"no {axis.rate} was recorded that changes; record it, or name its column: --column {axis.rate}=NAME"
        for axis in AXES.values()
        if axis.name not in axes
    }


def _beside_lags(vehicle: Vehicle) -> list[str]:
    """A sentence on the axes whose inertias only the form of a lag tells apart from that lag."""
    late = [
        f"{axis} {'rotors' if axis in vehicle.rotor_lags else 'effort'} {lag.value:.2g} s"
        for axis, lag in vehicle.all_lags.items()
        if lag.value > 0.0
    ]
    if not late:
        return []
    return [
        f"the lags ({', '.join(late)}) are taken as first order: where propellers lag otherwise, these inertias "
        "may be off by more than their intervals; give the efforts that the recorded speeds of the propellers make"
    ]


def _too_coarse(model: Fit, found: Mapping[str, Interval], runs: Sequence[Streams]) -> list[str]:
    """A sentence on each axis whose inertia depends on how often it was sampled, with the rate that would show it."""
    structure, warnings = model.structure, []
    constants = time_constants(structure, model.theta, runs, 0.95)
    for axis, constant in zip(structure.axes, constants.tolist(), strict=True):
        one = found.get(f"mass:{axis}")
        if one is None or axis not in structure.driven:
            continue
        wide = one.high - one.low > 2.0 * SURE_SHARE * one.value
        now = 1.0 / max(period(runs, axis), period(runs, effort_of(axis)))
        rate = SAMPLES_A_CONSTANT / constant
        if one.moved > 1.0 and wide and rate > 1.2 * now:
            name = of_rate(axis).name
            warnings.append(
                f"to tell the {name} inertia within 5 % record at {rate:.2g} Hz or more, not at {now:.2g} Hz"
            )
    return warnings
