"""What acts for an instant is looked for in shorter blocks, beside what their noise feigns there."""

from __future__ import annotations

import pytest

from incsvr.tracer.run import Run
from incsvr.tracing import trace
from simulator.trial import Outcome, Trial, play


def swinging(seed: int, size: float) -> tuple[Run, Outcome]:
    """A vehicle under one sine, its torque recorded with lasting noise, with friction of this size or none."""
    hidden = ("coulomb",) if size else ()
    outcome = play(Trial(seed, hidden, size, "leng", "sine", 0.9, noise="torque"))
    channels = dict(outcome.recording.columns)
    rate, torque = channels.pop("yaw_rate"), channels.pop("torque")
    return Run("swinging", outcome.recording.time, rate, torque, channels), outcome


@pytest.mark.parametrize("seed", [11, 12])
def test_friction_where_a_turn_reverses_is_found(seed: int) -> None:
    """In the longer blocks a reversal is one block of thirty, and a curve d(r) takes most of it."""
    run, outcome = swinging(seed, 1.0)
    (found,) = trace([run], inertia=outcome.inertia).effects
    assert found.effect == "coulomb"
    assert "torque_delay" not in found.cannot_tell_from  # what the gyro's noise feigns in so short blocks is no rival
    assert found.parameters["moment_nm"] == pytest.approx(outcome.truth["coulomb"]["moment_nm"], rel=0.35)


@pytest.mark.parametrize("seed", [11, 12])
def test_none_is_found_where_there_is_none(seed: int) -> None:
    run, outcome = swinging(seed, 0.0)
    assert trace([run], inertia=outcome.inertia).effects == ()


def test_what_longer_blocks_say_otherwise_is_not_believed() -> None:
    """Under steps shorter blocks make of a weak inflow one of three times its size."""
    outcome = play(Trial(700_037, ("inflow",), 0.5, "small", "steps", 0.9))
    channels = dict(outcome.recording.columns)
    rate, torque = channels.pop("yaw_rate"), channels.pop("torque")
    found = trace([Run("jumping", outcome.recording.time, rate, torque, channels)], inertia=outcome.inertia)
    assert found.effects == ()
    (inflow,) = [refused for refused in found.rejected if refused.effect == "inflow"]
    assert "in blocks of" in inflow.reason


def test_what_lasts_is_a_rival_where_the_longer_blocks_say_so() -> None:
    """Half the usual change of inertia: an inflow explains as much, and the shorter blocks cannot judge an inertia."""
    outcome = play(Trial(310_021, ("inertia",), 0.5, "leng", "multisine", 0.9))
    channels = dict(outcome.recording.columns)
    rate, torque = channels.pop("yaw_rate"), channels.pop("torque")
    (found,) = trace([Run("turning", outcome.recording.time, rate, torque, channels)], inertia=outcome.inertia).effects
    assert "inertia" in (found.effect, *found.cannot_tell_from)
    assert found.next_manoeuvre
