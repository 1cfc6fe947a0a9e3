"""What the equation and the free runs tell each by itself needs less evidence of either."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import combine_pvalues, ttest_1samp

from incsvr.evidence import evidence, p_value, together
from incsvr.tracer.asked import LEVEL, WITNESS
from incsvr.tracer.comparison import chance
from incsvr.tracer.inquiry import _evident, inquire, p_value_of
from incsvr.tracer.run import Run
from simulator.trial import Trial, play


def test_chance_is_students() -> None:
    gain = np.random.default_rng(0).normal(0.4, 1.0, 20)
    assert chance(gain) == pytest.approx(float(ttest_1samp(gain, 0.0, alternative="greater").pvalue))
    assert chance(-gain) == pytest.approx(1.0 - chance(gain))
    assert chance(gain[:1]) == 1.0


def test_two_witnesses_are_fishers() -> None:
    assert together(1e-3, 2e-4) == pytest.approx(float(combine_pvalues([1e-3, 2e-4], "fisher").pvalue))


def test_an_effect_that_both_tell_is_named_and_in_closed_loop_it_is_not() -> None:
    """Half an added mass in rough water: too little for the equation alone, and every held-out piece runs better."""
    outcome = play(Trial(355_021, ("inertia",), 0.5, "leng", "multisine", 0.9, noise="torque"))
    columns = outcome.recording.columns
    run = Run("rough", outcome.recording.time, columns["yaw_rate"], columns["torque"], {})
    case, found, _ = inquire([run], outcome.inertia, None, [], {})
    assert found.names() == ("inertia",)
    effect = found.effects[0]
    alone = p_value(evidence(case.problem, found, 0), effect.core, effect.looks * len(case.effects))
    assert p_value_of(case, found, 0) < LEVEL < alone < WITNESS
    fed_back = replace(case, problem=replace(case.problem, feedback=1.0))
    refused = dict[str, str]()
    assert _evident(fed_back, found, refused).names() == ()
    assert "noise of this colour" in refused["inertia"]
