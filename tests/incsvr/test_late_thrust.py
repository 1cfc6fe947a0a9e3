"""A thrust that comes late: how late is told from its start on, and in a loop that it keeps from settling."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects import catalogue
from incsvr.tracing import trace
from incsvr.tracing.run import Run
from incsvr.tracing.weak.hypothesis import nothing, views
from incsvr.tracing.weak.scan import scan
from simulator.trial import Trial, play
from tests.incsvr.turning import command, instants, turning


@pytest.mark.parametrize("late", [3, 8])
def test_the_search_begins_at_the_start_next_to_the_delay(late: int) -> None:
    """A secant of any other start, times what it likes, explains as much."""
    torque = command(0, instants(400.0))
    thrust = np.concatenate([np.zeros(late), torque[:-late]])
    problem = turning(0, torque, outside=thrust - torque)
    base, delay = nothing(problem), catalogue([])["torque_delay"]
    (lead,) = scan(problem, base, [delay], coloured=False)
    starts = [start for (start,) in delay.starts(views(problem, base).of(delay))]
    assert lead.inner == (min(starts, key=lambda start: abs(start - 0.05 * late)),)


def test_a_delay_that_keeps_a_loop_from_settling_is_found() -> None:
    """The rate then forgets itself in little more than the delay, and sooner than the vehicle settles by itself."""
    outcome = play(Trial(360_103, ("torque_delay",), 1.0, "leng", "closed_loop", 0.5, 200.0))
    columns = outcome.recording.columns
    run = Run("swinging", outcome.recording.time, columns["yaw_rate"], columns["torque"], {})
    found = trace([run], inertia=outcome.inertia)
    assert [finding.effect for finding in found.effects] == ["torque_delay"]
    assert found.effects[0].parameters["delay_s"] == pytest.approx(outcome.truth["torque_delay"]["delay_s"], abs=0.03)
    # the noise is 3.5 N m, the torque's own deviation some 100
    assert found.error["after"]["torque_rmse"] < 5.0 < 50.0 < found.error["before"]["torque_rmse"]


@pytest.mark.parametrize("vehicle", ["leng", "small"])
def test_a_delay_of_commands_is_not_longer_by_the_time_that_they_stand(vehicle: str) -> None:
    outcome = play(Trial(949_001, ("torque_delay",), 1.0, vehicle, "telegraph", 0.5, 300.0, "commanded"))
    columns = outcome.recording.columns
    stands = float(np.median(np.diff(outcome.recording.time[np.isfinite(columns["torque"])])))
    run = Run("commands", outcome.recording.time, columns["yaw_rate"], columns["torque"], {})
    found = trace([run], inertia=outcome.inertia, torque="commanded")
    assert [finding.effect for finding in found.effects] == ["torque_delay"]
    delay = found.effects[0].parameters["delay_s"]
    assert delay == pytest.approx(outcome.truth["torque_delay"]["delay_s"], abs=0.25 * stands)
