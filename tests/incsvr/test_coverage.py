"""The intervals of inertias contain the truth as often as they say."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from incsvr.vehicle import identify
from simulator.vehicles import BODIES, NAMES
from tests.worlds import swim


@pytest.mark.slow
def test_inertias_of_eight_vehicles_lie_in_their_intervals_of_95_percent() -> None:
    """A number of hits that is rarer than one in a hundred, if each had a chance of 95 %, is too few."""
    hits, widths = [], []
    for seed in range(905470, 905478):
        body = BODIES[("torpedo", "boat")[seed % 2]](np.random.default_rng(seed))
        found = identify([swim(body, 100.0, seed)], validate=False).vehicle
        for axis in body.moves:
            true, one = body.mass[NAMES.index(axis), NAMES.index(axis)], found.mass[axis, axis]
            hits.append(one.low <= true <= one.high)
            widths.append(one.high / one.low)
    assert len(hits) == 24
    assert np.quantile(widths, 0.9) < 1.15
    assert sum(hits) >= binom.ppf(0.01, len(hits), 0.95)
