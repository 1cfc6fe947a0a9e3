"""The torque as a constant and a few tones, run by run."""

from __future__ import annotations

import numpy as np

from incsvr.tracing.run import Run
from incsvr.tracing.weak.grid import on_fine_grid
from incsvr.tracing.weak.tones import as_tones
from incsvr.tracing.weak.weak_form import SUBSTEPS, split

STEP = 0.05


def test_a_run_that_is_shorter_than_a_block_is_told_as_it_is() -> None:
    time = np.concatenate([np.arange(0.0, 0.4, STEP), np.arange(10.0, 60.0, STEP)])
    torque = np.where(time < 5.0, 3.0 + time, 20.0 * np.sin(0.5 * time))
    signals = on_fine_grid([Run("two", time, 0.01 * torque, torque, {})], STEP, [], zero_order_hold=False, inertia=1.0)
    blocks = split(signals.start, SUBSTEPS, STEP)
    short, long = signals.runs()
    assert np.diff(blocks.start)[0] == 0
    told = as_tones(signals, blocks)
    assert np.array_equal(told[short], signals.torque[short])
    assert np.sqrt(np.mean((told[long] - signals.torque[long]) ** 2)) < 1.0
