"""A log's streams over time, a panel for each kind of quantity, as `incsvr inspect LOG --plot FILE` writes them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from matplotlib import pyplot
from matplotlib.axes import Axes

from incsvr.numerics import Array
from viewer.drawing import MEASURED, PARTS, STYLE
from viewer.pauses import Pauses

Stream = tuple[Array, Array]
Spans = Sequence[tuple[float, float]]
KINDS = {
    r"(yaw|roll|pitch)_rate": "turn rate",
    r"surge|sway|heave": "velocity",
    r"torque|(roll|pitch)_torque": "torque",
    r"(surge|sway|heave)_force": "force",
    r"thruster_\d+_speed": "thruster speed",
    r"thruster_\d+_pwm": "thruster pulse",
    r"thruster_\d+_force": "thruster force",
}
"""Streams that share a panel, by their names; any other stream has a panel of its own."""
MAX_PANELS = 9
"""Panels of a figure: more are too flat to read on a page."""
SINCE_1970_S = 1e8
"""Stamps beyond count from 1970 [s]."""


def of_log(name: str, streams: Mapping[str, Stream], units: Mapping[str, str], armed: Spans | None = None) -> Any:
    """A figure of a log.

    Args:
        streams: stamps (n,) [s] and values (n,) by name.
        units: of the streams, where they have one.
        armed: spans in which the vehicle was armed [s], with grey outside of them; None where nothing says so.
    """
    panels: dict[str, list[str]] = {}
    for stream in streams:
        kind = next(
            (kind for form, kind in KINDS.items() if re.fullmatch(form, stream)),
            re.sub("_[xyz]$", "", stream).replace("_", " "),
        )
        panels.setdefault(kind, []).append(stream)
    drawn, left_out = list(panels.items())[:MAX_PANELS], list(panels)[MAX_PANELS:]
    begins = min((float(time[0]) for time, _ in streams.values() if time.size), default=0.0)
    since = begins if begins > SINCE_1970_S else 0.0
    ends = max((float(time[-1]) for time, _ in streams.values() if time.size), default=begins)
    with pyplot.rc_context(STYLE | {"font.size": 11}):
        figure = pyplot.figure(figsize=(6.5, 1.1 + 1.3 * max(len(drawn), 1)), dpi=150, layout="constrained")
        column = figure.subplots(max(len(drawn), 1), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (kind, members) in zip(column, drawn, strict=False):
            _panel(axes, {member: streams[member] for member in members}, since)
            unit = next((units[member] for member in members if units.get(member)), "")
            label = kind if len(members) > 1 else members[0].replace("_", " ")
            axes.set_ylabel(label + (f"\n[{unit}]" if unit else ""))
            for start, end in _outside(armed, begins, ends):
                axes.axvspan(start - since, end - since, color="#eceff2", zorder=0, linewidth=0)
        figure.align_ylabels(list(column))
        grey = "; grey: disarmed" if _outside(armed, begins, ends) else ""
        more = f"; not drawn: {', '.join(left_out)}" if left_out else ""
        column[0].set_title(f"{name}{grey}{more}", loc="left", pad=22.0 if drawn and len(drawn[0][1]) > 1 else 8.0)
        column[-1].set_xlim(begins - since, ends - since if ends > begins else None)
        column[-1].set_xlabel(
            f"time [s] since {datetime.fromtimestamp(since, UTC):%Y-%m-%d %H:%M:%S} UTC" if since else "time t [s]"
        )
    return figure


def _panel(axes: Axes, streams: Mapping[str, Stream], since: float) -> None:
    """The streams of one kind, each with its own colour and its word in the legend; a line ends at a pause."""
    for number, (name, (time, values)) in enumerate(streams.items()):
        if not time.size:
            continue
        colour = MEASURED if len(streams) == 1 else PARTS[number % len(PARTS)]
        at, value = Pauses().broken(time, values)
        axes.plot(at - since, value, color=colour, linewidth=1.1, label=name.removesuffix("_rate").replace("_", " "))
    if len(streams) > 1:
        short = {f"thruster {number}": str(number) for number in re.findall(r"thruster_(\d+)", " ".join(streams))}
        handles, labels = axes.get_legend_handles_labels()
        words = [next((to for of, to in short.items() if label.startswith(f"{of} ")), label) for label in labels]
        where = (1.0, 0.97)
        axes.legend(handles, words, ncols=len(words), loc="lower right", bbox_to_anchor=where, borderaxespad=0.0)


def _outside(spans: Spans | None, begins: float, ends: float) -> list[tuple[float, float]]:
    """What lies outside of the spans, between the ends [s]; nothing where the spans are not known."""
    if spans is None:
        return []
    edges = [begins, *(edge for span in spans for edge in span), ends]
    inside = [(max(a, begins), min(b, ends)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return [(a, b) for a, b in inside if b > a]
