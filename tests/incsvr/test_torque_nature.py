"""Whether a controller makes the torque of the rate, whose gyro it reads, and what is refused as too little motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.tracing import trace
from incsvr.tracing.run import Run
from incsvr.tracing.torque_nature import Loop, declared_nature, of_this_gyro
from incsvr.tracing.trace import nature_of
from service.recordings.recording import from_streams
from simulator.mission import Mission
from simulator.sensors import GYRO_NOISE, Sensor, schedule
from simulator.vehicles import TURNING
from simulator.world import play
from tests.incsvr.turning import INERTIA, command, instants, turning

TIME = instants(600.0)


def test_an_open_loop_is_open_however_wrong_the_inertia() -> None:
    run = turning(1, command(1, TIME))
    for wrong in (0.5, 1.0, 2.0):
        nature, loop = nature_of([run], wrong * INERTIA, [], None)
        assert loop is Loop.OPEN
        assert not nature.closed


def test_a_controller_of_this_gyro_closes_the_loop() -> None:
    run = turning(1, command(1, TIME), answer=400.0)
    nature, loop = nature_of([run], INERTIA, [], None)
    assert of_this_gyro([run])
    assert loop is Loop.CLOSED
    assert nature.closed


@pytest.mark.slow
def test_where_the_controller_has_another_gyro_nothing_is_sought_and_that_is_said() -> None:
    """A survey whose log holds another gyro than the controller's, with nothing hidden."""
    outcome = play(Mission(TURNING["auv"], "survey", 5, duration=600.0))
    commands, other = outcome.recording.streams()["torque"], Sensor("yaw_rate", 10.0, GYRO_NOISE, phase=0.4)
    samples = schedule(other, 600.0, np.random.default_rng(5))
    rate = np.interp(samples.at, outcome.time, outcome.true("yaw_rate")) + samples.error
    log = from_streams("survey", {"yaw_rate": (samples.stamps, rate), "torque": commands})
    run = Run("survey", log.time, log.columns["yaw_rate"], log.columns["torque"])
    assert not of_this_gyro([run])
    _, loop = nature_of([run], outcome.inertia, [], None)
    assert loop is Loop.OTHER_GYRO
    found = trace([run], inertia=outcome.inertia)
    assert found.effects == ()
    assert found.verdict == "unexplained"
    assert any("the controller reads another gyro" in note for note in found.notes)


def test_a_command_that_repeats_itself_holds_and_a_noisy_torque_does_not() -> None:
    run = turning(1, command(1, TIME))
    noisy = replace(run, torque=run.torque + np.random.default_rng(5).normal(0.0, 1.0, TIME.size))
    assert declared_nature([run], None).held
    assert declared_nature([noisy], None).noisy
    assert not declared_nature([noisy], "commanded").noisy


def drifting(torque: float) -> Run:
    random = np.random.default_rng(2)
    return Run("drifting", TIME, random.normal(0.0, 0.002, TIME.size), torque + random.normal(0.0, 3.5, TIME.size))


@pytest.mark.parametrize("torque", [0.0, 60.0])
def test_a_torque_that_moves_nothing_answers_nothing(torque: float) -> None:
    with pytest.raises(BadInput, match=r"too little motion.*drive turns both ways"):
        trace([drifting(torque)], inertia=INERTIA)
