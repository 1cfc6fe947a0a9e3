"""One screen, 80 columns wide, of what a learner hears, what it makes of it and why not; for `status`."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.console import Console as RichConsole
from rich.console import ConsoleOptions, Group, RenderableType
from rich.padding import Padding
from rich.rule import Rule
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from incsvr.learning.coefficients import NORMAL_95_DEVIATIONS
from incsvr.plant.axes import AXES, YAW, Axis
from incsvr.plant.words import words_of
from incsvr.signals import REQUIRED, TORQUE, YAW_RATE
from service.cli.terminal import behind, shown
from service.inputs.units import si_unit
from service.wire import Health, ModelSnapshot, StreamHealth


class Console(RichConsole):
    """A console on standard output, or on standard error."""

    def __init__(self, *, stderr: bool = False, **more: Any) -> None:
        super().__init__(**{"file": behind(sys.stderr if stderr else sys.stdout), **more})

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterator[Segment]:
        for segment in super().render(renderable, options):
            yield segment if segment.control else Segment(shown(segment.text), segment.style)


COLOURS = {"OK": "green", "WARN": "yellow", "ERROR": "red", "STALE": "magenta"}
SHOWN_RATES = 5
"""Rates at which the model is shown, over its trained range."""


def screen(prefix: str, health: Health, model: ModelSnapshot | None, axis: Axis = YAW) -> RenderableType:
    """The screen of one learner, in the words and units of its axis."""
    return Group(
        _head(prefix, health),
        Rule(style="dim"),
        _heard(health, axis),
        Text(),
        _facts(health, model, axis),
        *(_reasons(health) if health.reasons else ()),
    )


def _head(prefix: str, health: Health) -> RenderableType:
    head = Table.grid(expand=True)
    head.add_column()
    head.add_column(justify="right")
    level = Text.assemble((prefix, "bold"), "  ", (health.level, f"bold {COLOURS[health.level]}"))
    level.append("" if health.learning.state == "learning" and health.level == "OK" else f"  {health.learning.state}")
    head.add_row(level, Text(f"up {_duration(health.uptime_s)}", style="dim"))
    return head


def _heard(health: Health, axis: Axis) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), header_style="dim")
    table.add_column("input", no_wrap=True, min_width=12, max_width=18)
    for name, width in (
        ("value", 13),
        ("Hz", 5),
        ("age s", 5),
        ("clock s", 9),
        ("values", 9),
        ("lost", 4),
        ("held", 6),
    ):
        table.add_column(name, justify="right", no_wrap=True, min_width=width)
    for name, stream in health.streams.items():
        table.add_row(_called(name, axis), *_columns(name, stream, axis))
    return table


def _called(name: str, axis: Axis) -> str:
    """The name of a stream for people."""
    return words_of(axis).stream(name) if name in REQUIRED else name


def stream_unit(name: str, axis: Axis) -> str:
    """The unit of a learner's stream; empty where its name is no known one."""
    words = words_of(axis)
    return {YAW_RATE: words.rate_unit, TORQUE: words.effort_unit}.get(name) or si_unit(name)


def _columns(name: str, stream: StreamHealth, axis: Axis) -> tuple[str, ...]:
    unit = stream_unit(name, axis)
    value = "–" if stream.value is None else f"{stream.value:.3g} {unit}".strip()
    return (
        value,
        "–" if not stream.period_s else f"{1.0 / stream.period_s:.3g}",
        "never" if stream.age_s is None else f"{stream.age_s:.1f}",
        "–" if stream.t is None else f"{stream.t:.1f}",
        str(stream.received),
        str(stream.lost),
        str(stream.held),
    )


def _facts(health: Health, model: ModelSnapshot | None, axis: Axis) -> Table:
    facts = Table.grid(padding=(0, 2, 0, 0))
    facts.add_column(style="dim", no_wrap=True)
    facts.add_column()
    facts.add_row("samples", _made(health, axis))
    facts.add_row("learning", _learning(health))
    if model is None:
        facts.add_row("model", "none yet: the first follows the first batch")
        return facts
    words = words_of(axis)
    noise = "" if model.noise is None else f", noise {model.noise:.3g} {words.effort_unit}"
    traced = "" if model.inertia_in_force == model.inertia else f", traced ({model.inertia:g} declared)"
    inertia = f"{words.inertia_symbol} = {model.inertia_in_force:.4g} {words.inertia_unit}"
    held = f"{model.model.support_rate.size} vectors, {inertia}{traced}{noise}"
    facts.add_row("model", f"revision {model.revision}, iteration {model.iteration}, of {model.t:.1f} s")
    facts.add_row("", held)
    if model.model.trained_range is not None:
        rates = np.linspace(*model.model.trained_range, SHOWN_RATES)
        curve = model.model.predict(rates)
        rows = (
            (f"rate {words.rate_unit}", rates, 3),
            (f"damping {words.effort_unit}", curve.damping, 3),
            ("± (95 %)", NORMAL_95_DEVIATIONS * curve.doubt, 2),
        )
        for label, values, digits in rows:
            facts.add_row("", f"{label:<12s}" + "".join(f"{value:>10.{digits}g}" for value in values))
    names = [str(effect.get("effect", "?")) for effect in model.effects]
    if names:
        facts.add_row("effects", ", ".join(names))
    return facts


def _made(health: Health, axis: Axis) -> str:
    counters = health.counters
    made = f"{counters.get('samples', 0)} samples, {counters.get('iterations', 0)} iterations"
    refused = sorted(
        ((count, name.removeprefix("rejected:")) for name, count in counters.items() if name.startswith("rejected:")),
        reverse=True,
    )
    told = ", ".join(f"{count} {reason.replace('_', ' ')}" for count, reason in refused)
    spikes = {name: count for name, count in counters.items() if name.startswith("spikes:")}
    aside = ", ".join(f"{count} of {_called(name.removeprefix('spikes:'), axis)}" for name, count in spikes.items())
    return f"{made}; refused: {told or 'nothing'}" + (f"; left out as spikes: {aside}" if aside else "")


def _learning(health: Health) -> str:
    learning = health.learning
    covered = f"{100.0 * health.learned:.0f} % of the rate range covered by fresh samples"
    return covered if learning.state == "learning" else f"{learning.state} since {learning.since:.1f} s; {covered}"


def _reasons(health: Health) -> tuple[RenderableType, ...]:
    table = Table.grid(padding=(0, 1, 0, 0))
    table.add_column(style=COLOURS[health.level])
    table.add_column(overflow="fold")  # a long path is whole: people copy the command that it stands in
    for reason in health.reasons:
        table.add_row("!", f"{reason[:1].upper()}{reason[1:]}.")
    return (Text(), Padding(table, 0))


def _duration(seconds: float) -> str:
    minutes, hours = int(seconds // 60), int(seconds // 3600)
    if hours >= 48:
        return f"{hours // 24} days"
    return f"{hours} h {minutes % 60} min" if hours else f"{minutes} min" if minutes else f"{seconds:.0f} s"


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
    if model.model.trained_range is None:
        return "–"
    return f"{float(model.model.predict([0.5 * model.model.trained_range[1]]).damping[0]):.3g} {unit}"
