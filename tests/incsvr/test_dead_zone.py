"""A dead band: its width, that of either side, and what the recording's own steps look like."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.effects import catalogue
from tests.incsvr.turning import instants, turning

TIME = instants(400.0)
SINE = 60.0 * np.sin(2.0 * np.pi * TIME / 20.0)


@pytest.mark.parametrize("key", ["dead_zone/step", "dead_zone/shifted"])
def test_none_is_looked_for_within_the_steps_of_the_recorded_torque(key: str) -> None:
    """Of commands about zero most that are recorded as one step were less: thrust that is missing, but no dead band."""
    effect, signals = catalogue()[key], turning(0, SINE).signals
    assert min(effect.starts(signals))[0] < 3.0
    coarse = effect.starts(replace(signals, quantum=8.0))
    assert min(coarse)[0] == pytest.approx(12.0)
    assert all(low < high for low, high in (effect.bracket(replace(signals, quantum=8.0), start) for start in coarse))
