"""The damping where the vehicle hardly was: it goes on as it came."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.tracing.weak.damping import SPLINE, Damping
from incsvr.tracing.weak.weak_form import split
from incsvr.tracing.weak.whitening import fit, ridge

RATES = np.linspace(-1.0, 1.0, 201)


def test_a_spline_over_a_gap_goes_on_as_it_came() -> None:
    """No rate between 0.45 and 0.9, and six blocks beyond: they may not bend what lies between as they like."""
    basis, gained = Damping.over(RATES), []
    for seed in range(6):
        random = np.random.default_rng(seed)
        rate = np.concatenate([random.uniform(-1.0, 0.45, 1500), random.uniform(0.97, 1.0, 6)])
        drag = 30.0 * rate + 70.0 * rate * np.abs(rate)
        blocks = split(np.array([0, rate.size + 1]), 1, 0.5)
        y = drag + random.normal(0.0, 3.0, rate.size)
        found = [basis.columns(RATES) @ fit(y, basis.columns(rate), blocks, spline=s).theta for s in (0, SPLINE)]
        off = np.abs(np.stack(found) - (30.0 * RATES + 70.0 * RATES * np.abs(RATES)))
        free, held = np.max(off[:, (RATES > 0.5) & (RATES < 0.95)], axis=1)
        gained.append(held / free)
    assert max(gained) < 1.0
    assert np.mean(gained) < 0.7


def test_what_holds_the_spline_holds_no_straight_line_and_no_other_column() -> None:
    held = ridge(np.ones(SPLINE + 2), SPLINE)
    line = np.concatenate([np.arange(SPLINE, 0.0, -1.0), np.zeros(2)])  # to zero, where the last coefficient is
    assert line @ held @ line == pytest.approx(0.0, abs=1e-3)
    assert np.count_nonzero(held[SPLINE:, :SPLINE]) == 0
