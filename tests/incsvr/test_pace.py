"""A stream whose stamps come at another pace: a clock that runs fast, of one stream or of both, or a rate set anew."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from incsvr.numerics import Array
from tests.incsvr.test_checks import FAILS, error, guided, sound_error, streams


@pytest.mark.slow
@pytest.mark.parametrize("stream", ["torque", "yaw_rate"])
def test_a_clock_that_runs_fast_is_told_before_it_has_done_harm(stream: str) -> None:
    """The stamps tell it at once, on every seed; how soon a lag that grows by 5 ms a second is seen, too, is luck."""
    for seed in (2, 3, 4):
        state, verdicts = guided(streams({stream: lambda t, v, here, rng: (t + 0.005 * (t - FAILS) * here, v)}, seed))
        first = next(verdict for verdict in verdicts if verdict.findings)
        assert first.span[1] - FAILS <= 60.0
        assert any("drift apart" in finding.sentence for finding in first.findings)
        assert not any(verdict.learn for verdict in verdicts if verdict.span >= first.span)
        assert error(state) < 1.5 * max(sound_error(seed), 0.7)


def test_a_clock_of_both_streams_that_runs_fast_is_told_and_learning_goes_on() -> None:
    def fast(t: Array, v: Array, here: NDArray[np.bool_], rng: np.random.Generator) -> tuple[Array, Array]:
        return t + 0.005 * (t - FAILS) * here, v

    _, verdicts = guided(streams({"torque": fast, "yaw_rate": fast}))
    told_first = next(verdict for verdict in verdicts if verdict.findings)
    assert {finding.kind for finding in told_first.findings} == {"torque pace", "yaw_rate pace"}
    assert all(verdict.learn for verdict in verdicts)


def test_a_rate_of_sending_that_was_set_anew_is_learned_from_once_the_streams_are_seen_together() -> None:
    def slower(t: Array, v: Array, here: NDArray[np.bool_], rng: np.random.Generator) -> tuple[Array, Array]:
        at = np.where(here, FAILS + 1.01 * (t - FAILS), t)
        return at[at < t[-1]], np.interp(at[at < t[-1]], t, v)

    _, verdicts = guided(streams({"torque": slower}))
    aside = [verdict.span for verdict in verdicts if not verdict.learn]
    assert aside
    assert aside[-1][1] - FAILS < 240.0
    assert verdicts[-1].learn
    assert not verdicts[-1].findings
