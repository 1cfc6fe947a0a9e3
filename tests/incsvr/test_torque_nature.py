"""Whether a controller makes the torque of the rate, whose gyro it reads, and what is refused as too little motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.tracing import trace
from incsvr.tracing.run import Run
from incsvr.tracing.torque_nature import Loop, as_told, of_this_gyro
from incsvr.tracing.trace import forms_of
from tests.incsvr.turning import INERTIA, command, instants, turning

TIME = instants(600.0)


def test_an_open_loop_is_open_however_wrong_the_inertia() -> None:
    run = turning(1, command(1, TIME))
    for wrong in (0.5, 1.0, 2.0):
        forms, loop = forms_of([run], wrong * INERTIA, [], None)
        assert loop is Loop.OPEN
        assert [form.closed for form in forms] == [False]


def test_a_controller_of_this_gyro_closes_the_loop() -> None:
    run = turning(1, command(1, TIME), answer=400.0)
    forms, loop = forms_of([run], INERTIA, [], None)
    assert of_this_gyro([run])
    assert loop is Loop.CLOSED
    assert [form.closed for form in forms] == [True]


def test_of_a_controller_with_another_gyro_both_forms_must_name_an_effect() -> None:
    run = turning(1, command(1, TIME), answer=1500.0)
    noise = np.random.default_rng(4).normal(0.0, 3e-3, TIME.size)
    seen = replace(run, yaw_rate=run.yaw_rate + noise)
    assert not of_this_gyro([seen])
    forms, loop = forms_of([seen], INERTIA, [], None)
    assert loop is Loop.OTHER_GYRO
    assert [form.closed for form in forms] == [False, True]
    found = trace([seen], inertia=INERTIA)
    assert any("the controller reads another gyro" in note for note in found.notes)


def test_a_command_that_repeats_itself_holds_and_a_noisy_torque_does_not() -> None:
    run = turning(1, command(1, TIME))
    noisy = replace(run, torque=run.torque + np.random.default_rng(5).normal(0.0, 1.0, TIME.size))
    assert as_told([run], None).held
    assert as_told([noisy], None).noisy
    assert not as_told([noisy], "commanded").noisy


def drifting(torque: float) -> Run:
    random = np.random.default_rng(2)
    return Run("drifting", TIME, random.normal(0.0, 0.002, TIME.size), torque + random.normal(0.0, 3.5, TIME.size))


@pytest.mark.parametrize("torque", [0.0, 60.0])
def test_a_torque_that_moves_nothing_answers_nothing(torque: float) -> None:
    with pytest.raises(BadInput, match=r"too little motion.*drive turns both ways"):
        trace([drifting(torque)], inertia=INERTIA)
