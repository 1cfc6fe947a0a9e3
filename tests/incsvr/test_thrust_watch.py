"""Thrust that is lost, or back: found in closed loop, told from other changes, and never where nothing happens."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from incsvr.forecasting.command_cells import MIN_CELL_PERIODS, CommandCells
from incsvr.forecasting.thrust_watch import WATCH_PERIOD_S, ThrustChange, ThrustState, look
from incsvr.numerics import Array

INERTIA, STEP, HOLD = 24.0, 0.025, 4
ONSET_S, END_S = 240.0, 440.0
FAULT_S = 130.0


def sailed(
    thrust: Callable[[float], float] = lambda _: 1.0,
    damping: Callable[[float], float] = lambda _: 1.0,
    moment: Callable[[float], float] = lambda _: 0.0,
    hold: int = HOLD,
    gain: float = 34.0,
    lag: float = STEP,
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Rate and command of a vehicle under rate control in moving water, whose thrust and damping are scaled in time;
    each command holds for so many steps, the controller answers the rate with this gain [N m s/rad], and the rotors
    follow with this lag [s]."""
    random = np.random.default_rng(3)
    beats = round(END_S / (STEP * hold))
    turn = round(8.0 / (STEP * hold))
    wish = np.repeat(random.uniform(-0.4, 0.4, beats // turn + 1), turn)[:beats]
    noise, kicks = 0.002 * random.standard_normal(beats), 0.3 * random.standard_normal(beats * hold)
    rates, commands = np.empty(beats), np.empty(beats)
    rate, water, total, pushed = 0.0, 0.0, 0.0, 0.0
    for beat in range(beats):
        rates[beat] = rate + noise[beat]
        error = wish[beat] - rates[beat]
        total += 12.0 * error * STEP * hold
        commands[beat] = gain * error + total
        now = beat * hold * STEP
        for k in range(hold):
            water += -0.5 * STEP * water + STEP**0.5 * kicks[beat * hold + k]
            pushed += STEP / lag * (commands[beat] - pushed)
            acts = thrust(now) * pushed + water + moment(now)
            rate += STEP / INERTIA * (acts - damping(now) * rate * (9.0 + 26.0 * abs(rate)))
    time: Array = hold * STEP * np.arange(beats, dtype=np.float64)
    return (time, rates), (time, commands)


def found(rate: tuple[Array, Array], torque: tuple[Array, Array], inertia: float = INERTIA) -> list[ThrustChange]:
    cells = CommandCells.of(rate, torque, -np.inf, np.inf, held=True)
    state, changes = ThrustState(), []
    for end in np.arange(WATCH_PERIOD_S, END_S, WATCH_PERIOD_S):
        seen = cells.take(cells.end <= end)
        state, change = look(state, seen, inertia)
        if change is not None:
            changes.append(change)
    return changes


def lost_for_a_while(now: float) -> float:
    return 0.5 if ONSET_S <= now < ONSET_S + FAULT_S else 1.0


def test_thrust_that_is_lost_is_told_within_a_minute_and_so_is_its_return() -> None:
    lost, back = found(*sailed(thrust=lost_for_a_while))
    assert lost.seen - ONSET_S <= 60.0
    assert lost.since == pytest.approx(ONSET_S, abs=10.0)
    assert lost.level[0] == pytest.approx(0.5, abs=0.1)
    assert not lost.is_back
    assert back.is_back
    assert back.seen - (ONSET_S + FAULT_S) <= 60.0


def test_rotors_that_lag_and_a_wrong_inertia_hide_no_loss() -> None:
    """What is lost is a part of the thrust that usually acts, with its lag, whatever inertia was declared."""
    lost, back = found(*sailed(thrust=lost_for_a_while, lag=0.3), inertia=1.9 * INERTIA)
    assert lost.seen - ONSET_S <= 60.0
    assert lost.level[0] == pytest.approx(0.5, abs=0.1)
    assert back.is_back
    assert found(*sailed(lag=0.3), inertia=1.9 * INERTIA) == []


def test_a_cell_lasts_about_as_long_as_a_command_is_held() -> None:
    """A log of a hundred values a second holds five commands a second."""
    time: Array = 0.01 * np.arange(1000.0, dtype=np.float64)
    commands = np.random.default_rng(1).normal(size=50).repeat(20)
    cells = CommandCells.of((time, np.sin(time)), (time, commands), -np.inf, np.inf, held=True)
    assert cells.length == pytest.approx(MIN_CELL_PERIODS * 0.2)


@pytest.mark.slow
def test_of_quick_commands_the_loss_is_told_whole() -> None:
    """Forty commands a second of a quick controller: within 0.1 s the later ones answer what the first left over."""
    lost, *_ = found(*sailed(thrust=lost_for_a_while, hold=1, gain=15.0 * INERTIA))
    assert lost.seen - ONSET_S <= 60.0
    assert lost.level[0] == pytest.approx(0.5, abs=0.08)
    assert found(*sailed(hold=1, gain=15.0 * INERTIA)) == []


@pytest.mark.parametrize(
    "other",
    [
        {},
        {"damping": lambda now: 1.5 if now >= ONSET_S else 1.0},
        {"moment": lambda now: 2.0 if now >= ONSET_S else 0.0},
        {"thrust": lambda now: 1.5 if now >= ONSET_S else 1.0},
    ],
    ids=["nothing", "damping", "moment", "more thrust"],
)
def test_what_is_no_loss_of_thrust_is_not_told(other: dict[str, Any]) -> None:
    assert found(*sailed(**other)) == []


def test_a_gyro_that_is_stuck_is_no_loss_of_thrust() -> None:
    (time, rate), torque = sailed()
    stuck = np.where(time < ONSET_S, rate, rate[np.searchsorted(time, ONSET_S)])
    assert found((time, stuck), torque) == []
