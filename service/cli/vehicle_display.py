"""The axes of one vehicle that a process learns together, a line each, 80 columns wide; for `status`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from incsvr.plant.axes import AXES
from incsvr.plant.words import words_of
from service.cli.display import COLOURS
from service.wire import Health, ModelSnapshot


@dataclass(frozen=True, slots=True)
class AxisState:
    """The answers of one axis's learner: its health, and its model, if there is one."""

    health: Health
    model: ModelSnapshot | None


def vehicle_screen(vehicle: str, axes: Mapping[str, AxisState]) -> RenderableType:
    """A line for each axis, below the vehicle's name and the gravest level of health."""
    gravest = max((state.health.level for state in axes.values()), key=list(COLOURS).index)
    head = Text.assemble((vehicle, "bold"), "  ", (gravest, f"bold {COLOURS[gravest]}"), f"  {len(axes)} axes")
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), header_style="dim")
    for name, justify in (("axis", "left"), ("health", "left"), ("learning", "left"), ("velocity", "right")):
        table.add_column(name, justify=justify, no_wrap=True)  # type: ignore[arg-type]
    for name in ("effort", "Hz", "revision", "covered", "at half speed"):
        table.add_column(name, justify="right", no_wrap=True)
    for axis, state in axes.items():
        table.add_row(*_line(axis, state))
    return Group(head, table)


def _line(axis: str, state: AxisState) -> tuple[str | Text, ...]:
    """Axis, level, state, newest velocity and effort, rate of the gyro, revision, coverage, and the damping at half of
    the fastest learned velocity."""
    health, words = state.health, words_of(AXES[axis])
    rate, effort = (health.streams.get(name) for name in ("yaw_rate", "torque"))
    return (
        axis,
        Text(health.level, style=COLOURS[health.level]),
        health.learning.state,
        _value(None if rate is None else rate.value, words.rate_unit),
        _value(None if effort is None else effort.value, words.effort_unit),
        "–" if rate is None or not rate.period_s else f"{1.0 / rate.period_s:.3g}",
        str(health.revision),
        f"{100.0 * health.learned:.0f} %",
        "–" if state.model is None else _damping(state.model, words.effort_unit),
    )


def _value(value: float | None, unit: str) -> str:
    return "–" if value is None else f"{value:.3g} {unit}"


def _damping(model: ModelSnapshot, unit: str) -> str:
    """The damping at half of the fastest velocity that was learned."""
    if model.trained_range is None:
        return "–"
    return f"{float(model.model().predict([0.5 * model.trained_range[1]]).damping[0]):.3g} {unit}"
