"""The manoeuvres that would show what recordings do not: one sentence for each parameter or diverging free run."""

from __future__ import annotations

from collections.abc import Sequence

from incsvr.plant.axes import AXES
from incsvr.plant.terms import AXES_BY_RATE, LINEAR, QUADRATIC, mass_unit
from incsvr.vehicle.model import ASSUMED, BOUND_REACHED, UNKNOWN, Vehicle
from incsvr.vehicle.prediction import Errors


def manoeuvres(vehicle: Vehicle) -> tuple[str, ...]:
    """The manoeuvres for the parameters that the recordings do not determine."""
    found: list[str] = []
    for (one, other), parameter in vehicle.mass.items():
        what = f"the {one} inertia" if one == other else f"the inertia that couples {one} and {other}"
        steps = _steps((one, other), vehicle.driven)
        if parameter.origin == BOUND_REACHED:
            found.append(
                f"the recordings do not determine {what}: its value, {parameter.value:.4g} {mass_unit(one, other)}, is "
                f"the bound of the search (bound reached); {steps}, faster than the vehicle settles, and record the "
                "velocities along all axes that move, or declare it with --set vehicle.mass_matrix=…"
            )
        elif parameter.origin == UNKNOWN:
            found.append(f"{what} is not excited: {steps}, faster than the vehicle settles")
        elif parameter.origin == ASSUMED and one == other:
            found.append(
                f"the {one} inertia is assumed, because no effort acts along {one}: declare it with "
                "--set vehicle.mass_matrix=…"
            )
    for term, parameter in vehicle.terms.items():
        if parameter.origin != UNKNOWN:
            continue
        if term.kind in (LINEAR, QUADRATIC) and term.axis in vehicle.driven:
            how = f"hold several {term.axis} speeds, slow and fast, to both sides"
        else:
            of = [AXES_BY_RATE[name].name if name in AXES_BY_RATE else name for name in term.of]
            how = f"{_steps((*of, term.axis), vehicle.driven)}, to both sides and in several sizes"
        found.append(f"{term.axis} {term.name} is not excited: {how}")
    return tuple(dict.fromkeys(found))


def _steps(axes: Sequence[str], driven: Sequence[str]) -> str:
    """The advice to change the efforts of axes in steps: of those with an actuator, or where none has one, of all."""
    those = [axis for axis in dict.fromkeys(axes) if axis in driven] or driven
    return f"change the {' and '.join(those)} effort{'s' * (len(those) > 1)} in steps"


def divergences(errors: Errors, driven: Sequence[str]) -> tuple[str, ...]:
    """A sentence on each axis whose free run errs by more than a vehicle at rest would, with the cure."""
    return tuple(
        f"the free run of {axis} diverges: over whole dives it errs by {model:.3g}, a velocity of zero by {zero:.3g} "
        f"{'m/s' if AXES[axis].along else 'rad/s'}; use the model for predictions of some seconds, and record a "
        f"manoeuvre that varies the {axis} speed: {_steps((axis,), driven)}, each held until the speed settles"
        for axis, model, zero in zip(errors.axes, errors.free_run.tolist(), errors.zero.tolist(), strict=True)
        if not model < zero
    )
