"""A dead band: its width, that of either side, and what the recording's own steps look like."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.effects import catalogue
from incsvr.tracing.run import Run
from incsvr.tracing.weak.acceptance import forbidden
from incsvr.tracing.weak.alignment import aligned
from incsvr.tracing.weak.hypothesis import nothing, settle
from simulator.trial import Trial, play
from tests.incsvr.trials import as_run
from tests.incsvr.turning import instants, turning

TIME = instants(400.0)
SINE = 60.0 * np.sin(2.0 * np.pi * TIME / 20.0)


def test_a_steps_edge_is_found_from_the_starts_beside_it() -> None:
    """A sixth beside it next to nothing is explained: a search from starts further apart would pass it."""
    outcome = play(Trial(190_104, ("dead_zone",), vehicle="small", excitation="closed_loop", autocorrelation=0.9))
    columns, truth = outcome.recording.columns, outcome.truth["dead_zone"]
    assert truth["shape"] == "jump"
    width = float(truth["half_width_nm"])
    problem = aligned([Run("loop", outcome.recording.time, columns["yaw_rate"], columns["torque"], {})],
                         outcome.inertia, [])  # fmt: skip
    base, step = nothing(problem), catalogue()["dead_zone/step"]
    starts = sorted(step.starts(problem.signals), key=lambda start: abs(start[-1] - width))[:2]
    tried = [settle(problem, [(step, start, ())], base, frozenset({step.key})) for start in starts]
    found = max(tried, key=lambda hypothesis: hypothesis.criterion)
    assert found.terms[0].inner[-1] == pytest.approx(width, rel=0.03)
    assert found.criterion > base.criterion + 400.0
    beside = settle(problem, [(step, (1.17 * width,), ())], base)
    assert beside.criterion < base.criterion + 40.0


@pytest.mark.parametrize("key", ["dead_zone/step", "dead_zone/shifted"])
def test_none_is_looked_for_within_the_steps_of_the_recorded_torque(key: str) -> None:
    """Of commands about zero most that are recorded as one step were less: thrust that is missing, but no dead band."""
    effect, signals = catalogue()[key], turning(0, SINE).signals
    assert min(effect.starts(signals))[0] < 3.0
    coarse = effect.starts(replace(signals, quantum=8.0))
    assert min(coarse)[0] == pytest.approx(12.0)
    assert all(low < high for low, high in (effect.bracket(replace(signals, quantum=8.0), start) for start in coarse))


def test_a_band_that_the_command_but_jumps_over_is_none() -> None:
    """Between its levels it passes through the band within a sample, and when that was nobody knows."""
    outcome = play(Trial(430_058, (), 1.0, "leng", "telegraph", 0.9))
    problem = aligned([as_run(outcome)], outcome.inertia, [], holds=False)
    base, step = nothing(problem), catalogue()["dead_zone/step"]
    found = settle(problem, [(step, (44.4,), ())], base)
    assert found.criterion > base.criterion + 20.0
    reason, k = forbidden(problem, found)
    assert k == 0
    assert "where the command jumps" in reason
