"""What sits in thrust, gyro and dry friction: found where it is plain, told from its neighbours, absent else."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.effects import candidates
from incsvr.samples import Array
from incsvr.tracing import trace
from incsvr.tracing.model import simulate
from incsvr.tracing.run import Run
from incsvr.tracing.weak.hypothesis import nothing, settle
from incsvr.tracing.weak.indistinguishable import indistinguishable
from incsvr.tracing.weak.modelled import model_of
from incsvr.tracing.weak.posing import pose
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.scan import scan
from tests.incsvr.test_coriolis import STEP, wandering
from tests.incsvr.turning import PERIOD, instants, turning

INERTIA, TOP = 24.0, 18.0
THRESHOLD = 12.0
"""Of the criterion that an effect must bring."""


@dataclass(frozen=True)
class Hidden:
    """What the vehicle of these tests has beside I ṙ + 9 r + 26 r|r| = τ."""

    exponent: float = 1.0
    step: float = 0.0
    drift: float = 0.0
    square: float = 0.0
    gyro: float = 0.0
    forward: float = 0.0
    backward: float = 0.0


def vehicle(hidden: Hidden, seed: int = 1, count: int = 2400) -> Run:
    random = np.random.default_rng(seed)
    command = np.repeat(random.uniform(-TOP, TOP, count // 25), 25)
    water, surge = wandering(random, count, 0.5, 0.3), 1.0 + wandering(random, count, 4.0, 0.25)
    time: Array = STEP * np.arange(count, dtype=np.float64)
    late = time > 0.5 * time[-1]
    thrust = TOP * np.sign(command) * np.abs(command / TOP) ** hidden.exponent
    thrust *= (1.0 + hidden.step * late) * (1.0 + hidden.drift * time / time[-1])
    thrust *= 1.0 + hidden.square * (surge**2 - 1.0)
    rate = np.zeros(count)
    for k in range(count - 1):
        r = rate[k]
        for _ in range(8):
            moment = thrust[k] + water[k] - 9.0 * r - 26.0 * r * abs(r)
            friction = hidden.forward * max(np.tanh(r / 0.002), 0.0) + hidden.backward * min(np.tanh(r / 0.002), 0.0)
            r += STEP / 8.0 / INERTIA * (moment - friction)
        rate[k + 1] = r
    measured = rate + hidden.gyro + random.normal(0.0, 0.002, count)
    return Run("vehicle", time, measured, command, {"surge": surge})


def posed(hidden: Hidden) -> Problem:
    return pose([vehicle(hidden)], INERTIA, ["surge"], zero_order_hold=True)


PLAIN = [
    ("thrust_curve", Hidden(exponent=1.8), "exponent", 1.8, ("dead_zone", "inertia")),
    ("thrust_step", Hidden(step=-0.4), "fraction", -0.4, ("drag_step", "inertia")),
    ("thrust_drift", Hidden(drift=-0.35), "fraction", -0.35, ("drag_drift", "inertia")),
    ("thrust_speed", Hidden(square=0.6), "coefficient", 0.6, ("coriolis:surge*yaw_rate", "modulation:surge")),
    ("gyro_bias", Hidden(gyro=0.06), "rate_rad_s", 0.06, ("coulomb", "inertia")),
    ("coulomb_asymmetry", Hidden(forward=3.0, backward=1.0), "moment_forward_nm", 3.0, ("coulomb", "bias_torque")),
]


@pytest.mark.parametrize(("name", "hidden", "parameter", "value", "neighbours"), PLAIN)
def test_it_is_found_where_it_is_plain(
    name: str, hidden: Hidden, parameter: str, value: float, neighbours: tuple[str, ...]
) -> None:
    problem = posed(hidden)
    base = nothing(problem)
    leads = scan(problem, base, candidates(["surge"]))
    own = [settle(problem, [(lead.effect, lead.inner, ())], base) for lead in leads if lead.effect.name == name]
    best = max(own, key=lambda each: each.criterion)
    assert best.criterion > base.criterion + 2.0 * THRESHOLD
    assert best.effects[0].parameters(best.terms[0], INERTIA)[parameter] == pytest.approx(value, rel=0.25)
    assert best.effects[0].implausible(best.terms[0], problem.signals) == ""
    for other in (lead for lead in leads if lead.effect.name in neighbours):
        assert settle(problem, [(other.effect, other.inner, ())], base).criterion < best.criterion


def test_it_is_absent_where_nothing_is_hidden() -> None:
    problem = posed(Hidden())
    base = nothing(problem)
    names = {name for name, *_ in PLAIN}
    for lead in scan(problem, base, [e for e in candidates(["surge"]) if e.name in names]):
        found = settle(problem, [(lead.effect, lead.inner, ())], base)
        assert found.criterion < base.criterion + THRESHOLD, lead.effect.key


def test_a_filtered_gyro_is_in_the_class_of_a_lagging_rotor() -> None:
    constant, white = 0.12, np.random.default_rng(9).normal(0.0, 8.0, instants(400.0).size)
    command = lfilter([1.0], [1.0, -0.98], white)
    kept = np.exp(-PERIOD / constant)
    problem = turning(9, command, outside=lfilter([1.0 - kept], [1.0, -kept], command) - command)
    lag = next(effect for effect in candidates() if effect.key == "torque_lag/moment")
    found = settle(problem, [(lag, (constant,), ())], nothing(problem))
    assert "gyro_lag" in {each.terms[-1].effect for each in indistinguishable(problem, found, 0, [lag])}


def test_friction_holds_a_vehicle_to_one_side_alone_in_a_free_run() -> None:
    """A moment of 2 N m turns it against the smaller friction and not against the larger."""
    problem = posed(Hidden(forward=3.0, backward=1.0))
    known = {effect.key: effect for effect in candidates()}
    found = settle(problem, [(known["coulomb_asymmetry/sharp"], (0.002,), ())], nothing(problem))
    model = model_of(problem, found)
    ends = []
    for moment in (2.0, -2.0):
        n = len(problem.signals)
        signals = replace(problem.signals, torque=np.full(n, moment), rate=np.zeros(n))
        _, simulated = simulate([model], signals, 0.05, [signals.runs()])
        ends.append(float(simulated[200]))
    assert abs(ends[0]) < 0.005  # it creeps
    assert ends[1] < -0.03


def test_what_changes_in_time_is_sought_on_one_clock_alone() -> None:
    """Two logs that both begin at zero: half a minute in the one is not half a minute in the other."""
    first, second = (vehicle(Hidden(step=-0.4), seed) for seed in (1, 2))
    later = replace(second, time=second.time + first.time[-1] + 10.0)
    for runs, one in (([first, second], False), ([first, later], True)):
        signals = pose(runs, INERTIA, ["surge"], zero_order_hold=True).signals
        assert signals.one_clock is one
        assert ("thrust_step" in {effect.name for effect in candidates([], one_clock=one)}) is one
    found = trace([first, second], inertia=INERTIA)
    assert not any(effect.needs_clock for effect in found.model.effects())
    assert any("stamps of the recordings overlap" in note for note in found.notes)
