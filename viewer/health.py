"""The page Health: how the learner does."""

from __future__ import annotations

from collections.abc import Mapping

import rerun as rr

from incsvr.plant.axes import AXES
from incsvr.plant.words import YAW_WORDS, AxisWords, words_of
from service.wire import Health
from viewer.frame import clock_text
from viewer.palette import LIGHT, Palette
from viewer.recorder import Recorder

SIGNS = {"OK": "OK", "WARN": "WARNING", "ERROR": "ERROR", "STALE": "NO DATA"}
AWAY = "AWAY"
NO_AXES: Mapping[str, Health] = {}
"""A learner that is the only one of its vehicle."""


class HealthPage:
    """Logs below signals/health/."""

    def __init__(self, rec: Recorder, palette: Palette) -> None:
        self._rec = rec
        self._level = ""
        rec.log(
            "signals/health/level",
            rr.StateConfiguration(
                values=[*SIGNS, AWAY],
                labels=[*SIGNS.values(), "LEARNER AWAY"],
                colors=[palette.support, palette.forgotten, palette.new, palette.discarded, palette.outlier],
            ),
            static=True,
        )
        rec.line("signals/health/learned", "Learned share", LIGHT.support, 2.5)

    def log(self, health: Health, axes: Mapping[str, Health] = NO_AXES) -> None:
        """The learner's health, and that of each axis of its vehicle, at the clocks that are set."""
        text = health_text(health, self._rec.words)
        self._rec.write("signals/health/now", f"{axes_text(health.vehicle, axes)}\n\n{text}" if axes else text)
        self._rec.log("signals/health/learned", rr.Scalars(health.learned))
        self._switch(health.level)

    def away(self, sentence: str) -> None:
        """The learner does not answer, at the clocks that are set."""
        text = f"# LEARNER AWAY\n\n{sentence}"
        self._rec.write("signals/health/now", text)
        self._switch(AWAY)

    def _switch(self, level: str) -> None:
        if level != self._level:
            self._level = level
            self._rec.log("signals/health/level", rr.StateChange(state=level))


def axes_text(vehicle: str, axes: Mapping[str, Health]) -> str:
    """Markdown; a line for each axis of the vehicle."""
    rows = []
    for axis, health in axes.items():
        rate, words = health.streams.get("yaw_rate"), words_of(AXES[axis])
        value = "-" if rate is None or rate.value is None else f"{rate.value:.3g} {words.rate_unit}"
        state = f"{SIGNS[health.level]} | {health.learning.state}"
        rows.append(f"| {axis} | {state} | {value} | {health.revision} | {100 * health.learned:.0f} % |")
    head = "| Axis | Health | Learning | Velocity | Revision | Learned |\n|:--|:--|:--|--:|--:|--:|"
    return "\n".join([f"# {vehicle}", head, *rows])


def health_text(health: Health, words: AxisWords = YAW_WORDS) -> str:
    """Markdown; the level large, then why, then every counter."""
    counters = [
        f"| {name.replace('_', ' ').replace(':', ': ')} | {count} |" for name, count in sorted(health.counters.items())
    ]
    streams = [
        f"| {name} | {one.received} | {one.lost} | {'-' if one.t is None else clock_text(one.t)} |"
        for name, one in sorted(health.streams.items())
    ]
    return "\n".join(
        [
            f"# {SIGNS[health.level]}",
            *(f"- {reason[:1].upper()}{reason[1:]}." for reason in health.reasons),
            "" if health.reasons else "Nothing to report.",
            f"\n**Learned: {100 * health.learned:.0f} % of the {words.rate} range** · iteration {health.iteration} · "
            f"revision {health.revision} · started as {health.boot}",
            "\n| Stream | Samples | Lost | Newest |\n|:--|--:|--:|--:|",
            *streams,
            "\n| Counter | Since start |\n|:--|--:|",
            *counters,
        ]
    )
