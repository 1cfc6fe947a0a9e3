"""The share of values that have nothing to do with their neighbours."""

from __future__ import annotations

from incsvr.checks.frozen_stream import STREAM_WORDS
from incsvr.checks.verdict import Decision, Finding
from incsvr.signals.raw import COUNT, SPIKES, named
from incsvr.signals.samples import Samples

OUTLIER_SHARES = {Decision.WARN: 0.04, Decision.PAUSE: 0.065}
"""Shares of a batch's values from which on outliers are said, and from which on nothing is learned: of windows of 36
values each holds several then, and about half of them stand beside each other, where no neighbour tells."""


def outliers(batch: Samples) -> list[Finding]:
    """The streams of a batch that have too many of them."""
    found = []
    for name, called in STREAM_WORDS.items():
        count = float(batch.raw[named(name, COUNT)].sum())
        share = float(batch.raw[named(name, SPIKES)].sum()) / count
        decision = max((each for each, least in OUTLIER_SHARES.items() if share >= least), default=Decision.CLEAN)
        if decision:
            found.append(
                Finding(
                    f"{name} outliers",
                    decision,
                    f"{100.0 * share:.0f} % of the {called}'s values are outliers from {batch.time[0]:.10g} to "
                    f"{batch.time[-1]:.10g} s; check the sensor and its wiring",
                )
            )
    return found
