"""The pages Signals (inputs, samples, the residual, refused values) and Health (how the learner does)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf

import numpy as np
import rerun as rr
from rerun.components import MarkerShape

from incsvr.plant.words import YAW_WORDS, AxisWords
from service.wire import Health
from viewer.frame import Frame, clock_text, markdown_table
from viewer.names import channel
from viewer.palette import LIGHT, Palette
from viewer.recorder import Recorder

ALL = "all_reasons"
HINT = "signals/clock"
CHANNELS = "signals/channel"
SWITCH = "# Choose *vehicle_time* below\n\nThe signals run on the vehicle's time, in the list at the lower left."
ON_TIME = (
    "All on the vehicle's time. Raw: as it came in. Synchronised: on the learner's grid, smoothed, from its own stamps."
)
OWN = ("yaw_rate", "torque")
SIGNS = {"OK": "OK", "WARN": "WARNING", "ERROR": "ERROR", "STALE": "NO DATA"}
AWAY = "AWAY"


@dataclass
class Raw:
    """What a stream brought that is not logged yet."""

    time: list[float] = field(default_factory=list)
    value: list[float] = field(default_factory=list)
    seen: list[float] = field(default_factory=list)


class SignalsPage:
    """Logs below signals/."""

    def __init__(self, rec: Recorder) -> None:
        self._rec = rec
        self._raw: dict[str, Raw] = {}
        self.channels: list[str] = []  # in the order in which they came
        self._rejected: dict[str, int] = {}
        self._explained = False
        self._drawn = -inf  # the vehicle's time of the newest sample that is logged [s]
        rec.line("signals/yaw_rate/raw", "Raw", LIGHT.old)
        rec.dots("signals/yaw_rate/synchronised", LIGHT.forgotten, "Synchronised", MarkerShape.Circle, 1.6)
        rec.line("signals/torque/raw", "Raw", LIGHT.before)
        rec.dots("signals/damping/synchronised", LIGHT.forgotten, "Sample", MarkerShape.Circle, 2.2)
        rec.line("signals/damping/predicted", "Model before it saw the sample", LIGHT.support, 2.0)
        rec.dots("signals/residual", LIGHT.new, "Sample - model", MarkerShape.Diamond, 2.6)

    def receive(self, name: str, time: Sequence[float], value: Sequence[float], seen: float) -> None:
        """Takes (n,) stamps of the vehicle [s] and values of a stream, come in at `seen` [s since 1970]."""
        raw = self._raw.setdefault(name, Raw())
        raw.time.extend(time)
        raw.value.extend(value)
        raw.seen.extend([seen] * len(time))

    def explain(self, iteration: int, vehicle: float) -> None:
        """Says on which clock the page runs: on the clock of iterations its plots would be empty without a word."""
        if self._explained:
            return
        self._explained = True
        self._rec.set_clocks(iteration=iteration)
        self._rec.write(HINT, SWITCH)
        self._rec.set_clocks(vehicle=vehicle)
        self._rec.write(HINT, ON_TIME)

    def flush(self) -> None:
        """Logs what came in since the last time."""
        for name, raw in self._raw.items():
            if not raw.time:
                continue
            path = f"signals/{name}/raw" if name in OWN else f"{CHANNELS}/{name}"
            if name not in OWN and name not in self.channels:
                self.channels.append(name)
                self._rec.line(path, channel(name))
            time, value, seen = (np.array(each, dtype=np.float64) for each in (raw.time, raw.value, raw.seen))
            self._rec.series(path, time, value, seen)
            self._raw[name] = Raw()

    def log(self, frame: Frame) -> None:
        """One iteration's samples, at the clocks that are set."""
        self.flush()
        batch = frame.report.batch
        time = np.array(batch.time)
        # A learner that changes over to other effects says its last batch again: what it said at the time stands.
        new = time > self._drawn
        if new.any():
            columns = {"yaw_rate/synchronised": batch.rate, "damping/synchronised": batch.damping}
            if batch.predicted is not None:
                columns["damping/predicted"] = batch.predicted
                columns["residual"] = tuple(np.subtract(batch.damping, batch.predicted))
            for path, values in columns.items():
                self._rec.series(f"signals/{path}", time[new], np.array(values)[new])
            self._drawn = batch.time[-1]

    def reject(self, counters: Mapping[str, int]) -> None:
        """The refused samples so far, altogether and by reason, at the clocks that are set."""
        reasons = {name.removeprefix("rejected:"): count for name, count in counters.items() if "rejected:" in name}
        counts = {ALL: sum(reasons.values()), **reasons}
        self._rejected |= counts
        for reason, count in self._rejected.items():
            self._rec.line(f"signals/rejected/{reason}", reason.replace("_", " ").capitalize(), width=2.0)
            self._rec.log(f"signals/rejected/{reason}", rr.Scalars(float(count)))


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

    def log(self, health: Health) -> None:
        """The learner's health, at the clocks that are set."""
        self._rec.write("signals/health/now", health_text(health, self._rec.words))
        self._rec.log("signals/health/learned", rr.Scalars(health.learned))
        self._switch(health.level)

    def away(self, sentence: str) -> None:
        """The learner does not answer, at the clocks that are set."""
        self._rec.write("signals/health/now", f"# LEARNER AWAY\n\n{sentence}")
        self._switch(AWAY)

    def _switch(self, level: str) -> None:
        if level != self._level:
            self._level = level
            self._rec.log("signals/health/level", rr.StateChange(state=level))


def health_text(health: Health, words: AxisWords = YAW_WORDS) -> str:
    """Markdown; the level large, then why, then every counter."""
    streams = [
        (name, one.received, one.lost, "-" if one.t is None else clock_text(one.t))
        for name, one in sorted(health.streams.items())
    ]
    counters = [(name.replace("_", " ").replace(":", ": "), count) for name, count in sorted(health.counters.items())]
    return "\n".join(
        [
            f"# {SIGNS[health.level]}",
            *(f"- {reason[:1].upper()}{reason[1:]}." for reason in health.reasons),
            "" if health.reasons else "Nothing to report.",
            f"\n**Learned: {100 * health.learned:.0f} % of the {words.rate} range** · iteration {health.iteration} · "
            f"revision {health.revision} · started as {health.boot}\n",
            *markdown_table(("Stream", "Samples", "Lost", "Newest"), streams),
            "",
            *markdown_table(("Counter", "Since start"), counters),
        ]
    )
