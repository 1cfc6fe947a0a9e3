"""A stream whose stamps come at another pace than before: its clock runs fast or slow, or its rate was changed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from incsvr.checks.frozen_stream import STREAM_WORDS
from incsvr.checks.verdict import Decision, Finding
from incsvr.numerics import Array
from incsvr.signals.raw import COUNT, PERIOD, TORQUE, named
from incsvr.signals.samples import Samples
from incsvr.signals.settings import YAW_RATE

PACE_CHANGE_RANGE = (0.003, 0.05)
"""A change of the period between two stamps, as a part, from which on it is a clock's and up to which it is one.
A quartz keeps a ten-thousandth; a batch in which messages are lost errs by 0.002; a rate set anew differs by more."""


def paces(
    batch: Samples,
    usual: Mapping[str, float],
    least: float = 9.0,  # deviations: quantiles err by more than means, the usual period's as well
) -> tuple[list[Finding], float]:
    """The streams of a batch that come at another pace than the periods `usual` [s] say, and by how much the torque's
    stamps ran ahead of the yaw rate's by that [s]: a clock that both are stamped with takes neither from the other."""
    changes = {name: period(batch, name) / usual[name] - 1.0 for name in STREAM_WORDS if usual.get(name)}
    changes = {name: change for name, change in changes.items() if abs(change) < PACE_CHANGE_RANGE[1]}
    lasted = float(np.ptp(batch.time))
    # what comes to less than a step between two stamps is their jitter, as is what windows beside each other differ by
    changes = {
        name: change
        for name, change in changes.items()
        if abs(change) * lasted > usual[name] and abs(change) * usual[name] > least * _jitter(batch, name)
    }
    apart = changes.get(TORQUE, 0.0) - changes.get(YAW_RATE, 0.0)
    decision = Decision.PAUSE if abs(apart) > PACE_CHANGE_RANGE[0] else Decision.WARN
    follows = "its clock runs at another speed, " + (
        "and the streams drift apart" if decision == Decision.PAUSE else "like that of the other stream"
    )
    found = [
        Finding(
            f"{name} pace",
            decision,
            f"the stamps of the {STREAM_WORDS[name]} are {1e3 * usual[name] * (1.0 + change):.5g} ms apart, "
            f"{100.0 * change:+.2g} % from those until {batch.time[0]:.10g} s: {follows}",
        )
        for name, change in changes.items()
        if abs(change) > PACE_CHANGE_RANGE[0]
    ]
    return found, apart * lasted if found and decision == Decision.PAUSE else 0.0


def _jitter(batch: Samples, name: str) -> float:
    """Deviation of a stream's mean period [s], by its shorter windows: lost messages make windows longer alone. Those
    that overlap err together: as many tell it as the batch holds beside each other."""
    each = _mean_periods(batch, name)
    if not each.size:
        return 0.0
    low, middle = np.quantile(each, (0.05, 0.3))
    window = float(np.median(batch.raw[named(name, COUNT)])) * float(middle)
    return float((middle - low) / np.sqrt(np.clip(np.ptp(batch.time) / window, 1.0, each.size)))


def period(
    batch: Samples,
    name: str,
    complete: float = 0.1,  # of the windows hold every message at least: one that is lost makes a window's step longer
) -> float:
    """The time between two stamps of a stream [s], whatever single messages were lost; 0 where no window has two."""
    each = _mean_periods(batch, name)
    return float(np.quantile(each, complete)) if each.size else 0.0


def _mean_periods(batch: Samples, name: str) -> Array:
    """The mean periods of the windows that hold more than one message [s]."""
    each = batch.raw[named(name, PERIOD)]
    return np.asarray(each[each > 0.0])
