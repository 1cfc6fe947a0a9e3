"""A stream whose stamps come at another pace than before: its clock runs fast or slow, or its rate was changed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from incsvr.samples import Samples
from incsvr.signals.checks.stuck import CALLED
from incsvr.signals.checks.verdict import Decision, Finding
from incsvr.signals.raw import PERIOD, named

PACE = (0.002, 0.05)
"""A change of the period between two stamps, as a part, from which on it is a clock's and up to which it is one:
a quartz keeps a ten-thousandth, and a rate that was set anew differs by more."""
COMPLETE = 0.3
"""The part of the windows that hold every message, at least: a lost one makes a window's mean period longer."""


def paces(batch: Samples, usual: Mapping[str, float]) -> list[Finding]:
    """The streams of a batch that come at another pace than the periods `usual` [s] say."""
    found = []
    for name, called in CALLED.items():
        if name not in usual:
            continue
        change = period(batch, name) / usual[name] - 1.0
        if PACE[0] < abs(change) < PACE[1]:
            found.append(
                Finding(
                    f"{name} pace",
                    Decision.WARN,
                    f"the stamps of the {called} come every {1e3 * usual[name] * (1.0 + change):.5g} ms, "
                    f"{100.0 * change:+.2g} % beside what they did until {batch.time[0]:.10g} s: its clock runs at "
                    "another speed, and the streams drift apart",
                )
            )
    return found


def period(batch: Samples, name: str) -> float:
    """The time between two stamps of a stream [s], whatever single messages were lost."""
    return float(np.quantile(batch.raw[named(name, PERIOD)], COMPLETE))
