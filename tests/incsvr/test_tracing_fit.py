"""A fit ends where the likelihood is greatest, wherever it begins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.compensation.fresh_data import as_run
from incsvr.numerics import Streams
from incsvr.tracing import innovations
from incsvr.tracing.fit import fit
from incsvr.tracing.torque_nature import TorqueNature
from tests.worlds import mission

COMMANDED = TorqueNature(held=True, noisy=False, closed=True)
MAX_LOG_LIKELIHOOD_APART = 2.0
"""The largest difference in log likelihood of two fits that have settled; a stuck fit is more than a hundred off."""


@pytest.fixture(scope="module")
def streams() -> Streams:
    """A transit in which nothing happens; each command holds until the next, so that none is late or early."""
    outcome = mission("transit", "rov", 952, 700.0)
    whole = outcome.recording.streams()
    return {name: whole[name] for name in ("yaw_rate", "torque")}


@pytest.mark.parametrize("begins", [400.0, 100.0])
def test_the_kink_of_the_offset_stops_no_fit(streams: Streams, begins: float) -> None:
    part = {
        name: (t[here], value[here])
        for name, (t, value) in streams.items()
        if (here := (t >= begins) & (t < begins + 300.0)).any()
    }
    problem = innovations.pose([as_run(part)], 0.6, [], COMMANDED, thinned=False)
    scores = [
        float(np.sum(fit(problem, problem.start, replace(problem.colour, reflection=start)).score))
        for start in (problem.colour.reflection, (0.0, 0.0), (-0.8, 0.3))
    ]
    assert np.ptp(scores) < MAX_LOG_LIKELIHOOD_APART
