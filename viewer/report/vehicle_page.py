"""The page of a whole vehicle: each axis's parameters, the errors of predictions, a free run, and what is not known."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from incsvr.plant.axes import AXES, YAW
from incsvr.plant.terms import mass_unit, stage_unit, thrust_name
from incsvr.plant.words import words_of
from incsvr.vehicle import Identified, Parameter
from incsvr.vehicle.model import BOUND_REACHED, ESTIMATED, UNKNOWN
from incsvr.vehicle.prediction import Course
from viewer.drawing import simulated_chart
from viewer.report.figures import between, capital, number, rendered

JUDGED_S = 5.0
"""How far ahead the headline speaks of [s]."""


def vehicle_page(found: Identified, notes: Sequence[str] = (), provenance: Mapping[str, str] | None = None) -> str:
    """The whole document.

    Args:
        notes: of the readers of the logs.
        provenance: what it was made of, and how.
    """
    vehicle = found.vehicle
    return rendered(
        "vehicle.html.j2",
        YAW,
        provenance,
        title="Vehicle",
        kicker=f"Whole vehicle {vehicle.name}, {found.seconds:.0f} s of motion",
        headline=_headline(found),
        summary=_summary(found),
        axes=[(capital(axis), axis in vehicle.driven, _rows(found, axis)) for axis in vehicle.axes],
        errors=_errors(found),
        track=found.errors.track.items(),
        where=where(found),
        charts=[] if found.course is None else free_runs(found.course),
        refusals=[capital(f"{axis}: {why}") for axis, why in found.refusals.items()],
        manoeuvres=[capital(sentence) for sentence in (*found.warnings, *found.manoeuvres)],
        notes=[capital(note) for note in notes],
    )


def where(found: Identified) -> str:
    """What the errors are of."""
    if found.unseen:
        return "dives that were not fitted"
    return "the dives' own parts, each predicted by a model of the other parts"


def free_runs(course: Course, seconds: float = 60.0) -> list[str]:
    """The beginning of the free run, a chart for each axis."""
    columns = zip(course.axes, course.measured.T, course.simulated.T, strict=True)
    return [
        simulated_chart(AXES[axis], course.time, measured, simulated, seconds) for axis, measured, simulated in columns
    ]


def _headline(found: Identified) -> list[str]:
    """What was identified, and what limits it."""
    axes = list(found.vehicle.axes)
    named = axes[0] if len(axes) == 1 else f"{', '.join(axes[:-1])} and {axes[-1]}"
    clauses = [capital(f"{named} {'is' if len(axes) == 1 else 'are'} identified")]
    every = (*found.vehicle.mass.values(), *found.vehicle.terms.values())
    unknown = sum(p.origin in (UNKNOWN, BOUND_REACHED) for p in every)
    clauses = [*map(capital, found.verdict), *clauses]
    if unknown:
        clauses.append(
            f"{unknown} {'parameter is' if unknown == 1 else 'parameters are'} not determined: see what to drive"
        )
    return clauses


def _summary(found: Identified) -> str:
    """How well it predicts, in a sentence; empty where no dive is long enough."""
    if JUDGED_S not in found.errors.horizons:
        return ""
    model, hold, _ = found.errors.horizons[JUDGED_S]
    shares = sorted(100.0 * m / max(h, 1e-12) for m, h in zip(model.tolist(), hold.tolist(), strict=True))
    span = f"{shares[0]:.0f} %" if len(shares) == 1 else f"{shares[0]:.0f} to {shares[-1]:.0f} %"
    return f"{JUDGED_S:g} s ahead the model's error is {span} of that of a held velocity, on {where(found)}."


def _rows(found: Identified, axis: str) -> list[tuple[str, str, str, str, str]]:
    """Name, unit, value, interval and remark of each parameter of an axis."""
    vehicle, inertia = found.vehicle, "effective inertia" if found.effective else "inertia"
    rows: list[tuple[str, str, Parameter]] = [
        (inertia if one == other else f"{inertia} with {other}", mass_unit(one, other), parameter)
        for (one, other), parameter in vehicle.mass.items()
        if one == axis
    ]
    rows += [(term.name, term.unit, parameter) for term, parameter in vehicle.terms.items() if term.axis == axis]
    rows += [("thrust lag", "s", parameter) for name, parameter in vehicle.lags.items() if name == axis]
    rows += [(thrust_name(name), stage_unit(axis, name), p) for name, p in vehicle.thrust.get(axis, {}).items()]
    return [(name, "" if unit == "1" else unit, number(p.value), _interval(p), _remark(p)) for name, unit, p in rows]


def _interval(parameter: Parameter) -> str:
    """Its interval; where it has none, where it comes from."""
    known = parameter.origin in (ESTIMATED, UNKNOWN, BOUND_REACHED)
    return between((parameter.low, parameter.high)) if known else parameter.origin


def _remark(parameter: Parameter) -> str:
    return parameter.origin if parameter.origin in (UNKNOWN, BOUND_REACHED) else ""


def _errors(found: Identified) -> list[dict[str, Any]]:
    """A table for each time ahead, and for the free run: axis, unit, model, held velocity, the axis by itself."""
    errors, alone = found.errors, [found.by_itself[axis] for axis in found.errors.axes]

    def table(title: str, trivial: str, *columns: Iterable[float | None]) -> dict[str, Any]:
        rows = [
            (axis, words_of(AXES[axis]).rate_unit, *map(number, values))
            for axis, *values in zip(errors.axes, *columns, strict=True)
        ]
        return {"title": title, "columns": ("model", trivial, "by itself"), "rows": rows}

    tables = []
    for ahead, (model, hold, _) in errors.horizons.items():
        own = [each.horizons.get(ahead) for each in alone]
        beside = (None if each is None else float(each[0][0]) for each in own)
        tables.append(table(f"{ahead:g} s ahead", "held", model.tolist(), hold.tolist(), beside))
    own_runs = (float(each.free_run[0]) for each in alone)
    return [*tables, table("Free run", "zero", errors.free_run.tolist(), errors.zero.tolist(), own_runs)]
