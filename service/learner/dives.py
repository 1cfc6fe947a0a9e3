"""A line for each dive of a learner: the drag that it had learned by the end, for `incsvr compare --from-learner`.

A dive begins with a start of the service, after a long pause of the data, or where their stamps begin anew.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from incsvr.learning.model import Model
from service.config.vehicle import Vehicle
from service.wire import IterationReport

MAX_PAUSE_S = 600.0
"""Longest pause between two batches of one dive [s]: a battery is not changed faster."""
MAX_DIVES = 300
"""Dives that are kept; the oldest go. The state, which is written with every iteration, holds 100 kB of them."""
SPEED_PART = 0.5
"""Part of the fastest configured velocity at which the drag is taken: most dives reach it, and there the curve is known
far better than N_r and N_{r|r|}, which trade off against each other."""
MIN_FREEDOM = 1
"""Degrees of freedom of a standard error at least."""


@dataclass(frozen=True, slots=True)
class DiveLine:
    """A dive.

    Attributes:
        axis: name of the learner's axis.
        boot: the start of the service in which it was.
        began, ended: when its first and its last batch came, by the clock on the wall [s since 1970].
        last_t: the vehicle's time of its newest sample [s].
        seconds: length of its data, pauses included [s].
        samples: how many were learned or put aside.
        rms_speed: RMS of its velocity [m/s] or [rad/s].
        effects: names of the traced effects that its samples were freed of.
        quantity: "drag", the mean of both directions, or "drag_ahead" or "drag_back" where one alone was learned.
        at_speed: at which velocity it is taken [m/s] or [rad/s].
        estimate, standard_error: the drag by the served model [N] or [N m].
        degrees_of_freedom: of the standard error: the model's vectors less the two terms of a drag.
    """

    axis: str
    boot: str
    began: float
    ended: float
    last_t: float
    seconds: float
    samples: int
    rms_speed: float
    effects: list[str]
    quantity: str
    at_speed: float
    estimate: float
    standard_error: float
    degrees_of_freedom: int


class Dives:
    """The lines of a learner, the oldest first; from the thread that learns.

    Args:
        vehicle: axis and configured velocities.
        stored: the lines as `to_list` gave them.
    """

    def __init__(self, vehicle: Vehicle, stored: Iterable[Mapping[str, Any]] = ()) -> None:
        self._axis, self._speed = vehicle.axis, SPEED_PART * max(map(abs, vehicle.rate_range))
        self._lines = [DiveLine(**each) for each in stored]

    def add(self, report: IterationReport, model: Model, effects: Iterable[Mapping[str, Any]], now: float) -> None:
        """Adds an iteration to the present dive, or begins another.

        Args:
            model: the served one.
            effects: in force.
            now: by the clock on the wall [s since 1970].
        """
        drag = _drag(model, self._speed)
        rate = np.array(report.batch.rate)
        if drag is None or rate.size == 0:
            return
        first = report.batch.time[0]
        began, seconds, samples, squares = now, report.t - first, rate.size, float(np.sum(rate**2))
        if self._lines and _goes_on(self._lines[-1], report):
            before = self._lines.pop()
            began, samples = before.began, before.samples + samples
            seconds = before.seconds + max(report.t - before.last_t, 0.0)
            squares += before.samples * before.rms_speed**2
        quantity, estimate, error, freedom = drag
        line = DiveLine(
            axis=self._axis,
            boot=report.boot,
            began=began,
            ended=now,
            last_t=report.t,
            seconds=seconds,
            samples=samples,
            rms_speed=math.sqrt(squares / samples),
            effects=[str(effect["effect"]) for effect in effects],
            quantity=quantity,
            at_speed=self._speed,
            estimate=estimate,
            standard_error=error,
            degrees_of_freedom=freedom,
        )
        self._lines = [*self._lines, line][-MAX_DIVES:]

    def to_list(self) -> list[dict[str, Any]]:
        """The lines as plain data."""
        return [asdict(line) for line in self._lines]


def _goes_on(line: DiveLine, report: IterationReport) -> bool:
    """Whether a batch belongs to the dive of a line; one that is learned again does."""
    length = report.batch.time[-1] - report.batch.time[0]
    return line.boot == report.boot and -length <= report.t - line.last_t <= MAX_PAUSE_S + length


def _drag(model: Model, speed: float) -> tuple[str, float, float, int] | None:
    """Quantity, estimate, standard error and degrees of freedom of the drag; None where it was not learned."""
    if not model.is_trained:
        return None
    found = model.predict((speed, -speed))
    learned = ~found.extrapolated
    if not learned.any():
        return None
    estimate = float(np.mean((found.damping * (1.0, -1.0))[learned]))
    error = float(np.sqrt(np.sum(found.doubt[learned] ** 2))) / int(learned.sum())
    quantity = "drag" if learned.all() else "drag_ahead" if learned[0] else "drag_back"
    return quantity, estimate, error, max(model.support_rate.size - 2, MIN_FREEDOM)
