"""The text of an identified vehicle for people, and what its axes are good enough for."""

from __future__ import annotations

from pathlib import Path

from incsvr.plant.axes import AXES
from incsvr.plant.terms import mass_unit, stage_unit, thrust_name
from incsvr.plant.words import words_of
from incsvr.vehicle import Identified, Parameter
from service.fitting.good_enough import Use, good_enough_lines, without_gyro


def uses(found: Identified) -> dict[str, Use]:
    """Axis → the verdict on its free run, of all axes at once."""
    errors = found.errors
    rows = zip(errors.axes, errors.free_run.tolist(), errors.zero.tolist(), errors.hold.tolist(), strict=True)
    return {name: without_gyro(model, zero, hold, words_of(AXES[name])) for name, model, zero, hold in rows}


HORIZON_HEAD = "  {:<28}{}"


def text(found: Identified, written: Path | None = None) -> str:
    """The result for people; `written` is the vehicle file."""
    vehicle = found.vehicle
    lines = [
        *found.verdict,
        f"vehicle {vehicle.name}: {found.seconds:.0f} s of motion, steps of {found.step:.3g} s",
        "",
    ]
    inertia = "effective inertia" if found.effective else "inertia"
    for axis in vehicle.axes:
        passive = "" if axis in vehicle.driven else " (no effort acts along it)"
        lines.append(f"{axis}{passive}")
        for (one, other), parameter in vehicle.mass.items():
            if one == axis:
                name = inertia if one == other else f"{inertia} with {other}"
                lines.append(_row(name, parameter, mass_unit(one, other)))
        lines += [_row(term.name, p, term.unit) for term, p in vehicle.terms.items() if term.axis == axis]
        lines += [_row("thrust lag", p, "s") for name, p in vehicle.lags.items() if name == axis]
        lines += [
            _row(thrust_name(name), p, stage_unit(axis, name)) for name, p in vehicle.thrust.get(axis, {}).items()
        ]
    lines += ["", *_errors(found)]
    if found.effective:
        lines.append("An effective inertia includes the share of axes that move with it and are not in the recordings.")
    for axis, why in found.refusals.items():
        lines.append(f"{axis} is not identified: {why}")
    lines += list(found.manoeuvres)
    lines += [f"warning: {each}" for each in found.warnings]
    if written is not None:
        lines += ["", f"written to {written}"]
    return "\n".join([*lines, "", *good_enough_lines(uses(found).values())])


def _row(name: str, parameter: Parameter, unit: str) -> str:
    value = f"{parameter.value:.4g}"
    if parameter.origin in ("declared", "assumed"):
        return f"  {name:<26}{value:>10}  {unit} ({parameter.origin})"
    remark = "" if parameter.origin == "estimated" else f" ({parameter.origin})"
    unit = "" if unit == "1" else unit
    return f"  {name:<26}{value:>10}  ({parameter.low:.4g} to {parameter.high:.4g}) {unit}{remark}".rstrip()


def _errors(found: Identified) -> list[str]:
    """RMS errors of predictions of all axes at once."""
    where = "other recordings" if found.unseen else "each part of the recordings, predicted by the others"
    errors = found.errors
    head = "".join(f"{axis:>12}" for axis in errors.axes)
    units = "".join(f"{'[m/s]' if AXES[axis].along else '[rad/s]':>12}" for axis in errors.axes)
    lines = [f"prediction error (RMS) on {where}, all axes at once", f"  {'':<28}{head}", f"  {'':<28}{units}"]
    for seconds, (model, hold, _) in errors.horizons.items():
        alone = [found.by_itself[axis].horizons.get(seconds) for axis in errors.axes]
        lines.append(HORIZON_HEAD.format(f"{seconds:g} s ahead: model", _numbers(model.tolist())))
        lines.append(HORIZON_HEAD.format("     velocity held", _numbers(hold.tolist())))
        if all(alone):
            singles = [float(each[0][0]) for each in alone if each]
            lines.append(HORIZON_HEAD.format("     each axis by itself", _numbers(singles)))
        if seconds in errors.track:
            lines.append(f"  {'     track':<28}{errors.track[seconds]:>12.3g} m")
    lines.append(HORIZON_HEAD.format("free run: model", _numbers(errors.free_run.tolist())))
    lines.append(HORIZON_HEAD.format("     velocity held", _numbers(errors.hold.tolist())))
    lines.append(HORIZON_HEAD.format("     zero velocity", _numbers(errors.zero.tolist())))
    singles = [float(found.by_itself[axis].free_run[0]) for axis in errors.axes]
    lines.append(HORIZON_HEAD.format("     each axis by itself", _numbers(singles)))
    lines.append("  Each axis by itself is given the other velocities as measured; the model predicts them, too.")
    return lines


def _numbers(values: list[float]) -> str:
    return "".join(f"{value:>12.3g}" for value in values)
