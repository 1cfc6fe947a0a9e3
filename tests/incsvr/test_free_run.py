"""The free run under dry friction, and how two free runs are compared where the water is noisy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.effects import Signals, Term, catalogue
from incsvr.tracing.model import TracedModel, simulate
from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.hypothesis import nothing, settle
from incsvr.tracing.weak.posing import pose
from incsvr.tracing.weak.validation import Validation
from simulator.trial import Trial, play
from tests.incsvr.turning import command, instants, turning

FRICTION = 6.0
"""[N m]."""
TABLE = np.linspace(-0.3, 0.3, 61)
RUBBING = TracedModel(
    350.0, TABLE, 100.0 * TABLE, (Term("coulomb", "", (FRICTION,), (0.002,)),), 1.0, 0.5, 6.0, (0.0, 100.0)
)


def under(torque: Array, rate: float = 0.0) -> Signals:
    """A free run of that command from that rate, a sample every 0.05 s."""
    none = np.zeros(torque.size)
    time = instants(torque.size * 0.05)
    return Signals(0.05, np.array([0, torque.size]), time, none + rate, torque, heading=none)


def test_friction_holds_a_vehicle_until_the_torque_exceeds_it() -> None:
    held = RUBBING.simulate(under(np.full(2000, 0.9 * FRICTION)))[1]
    freed = RUBBING.simulate(under(np.full(2000, 2.0 * FRICTION)))[1]
    assert np.max(np.abs(held)) < 2.0 * 0.002  # it creeps within the width of the tanh
    assert freed[-1] == pytest.approx(FRICTION / 100.0, rel=0.01)


def test_friction_ends_a_turn_and_never_reverses_it() -> None:
    rate = RUBBING.simulate(under(np.zeros(2000), rate=0.2))[1]
    assert np.all(np.diff(rate) <= 0.0)
    assert rate[-1] == pytest.approx(0.0, abs=1e-4)
    assert np.min(rate) >= 0.0


def test_a_reversal_costs_the_same_whatever_the_step() -> None:
    """Linearised, so steep a friction stalls every reversal for a step, and coarser steps fall behind."""
    time = instants(120.0)
    signals = under(60.0 * np.sign(np.sin(2.0 * np.pi * time / 9.7)))
    index, coarse = RUBBING.simulate(signals, 0.25)
    fine = RUBBING.simulate(signals, 0.05)[1]
    assert np.sqrt(np.mean((coarse - fine[index]) ** 2)) < 0.01 * np.std(fine)


def test_what_is_small_beside_the_slow_noise_shows_where_the_noise_is_small() -> None:
    """A dead band under a jumping command: in plain free runs the slow noise hides it, weighed it does not."""
    time = instants(600.0)
    torque = command(3, time)
    slow = lfilter([4.0], [1.0, -0.998], np.random.default_rng(3).normal(0.0, 1.0, time.size))
    problem = turning(3, torque, outside=slow - np.clip(torque, -7.0, 7.0))
    base = nothing(problem)
    found = settle(problem, [(catalogue()["dead_zone/shifted"], (7.0,), ())], base)
    weighed = Validation.of(problem, None, quick=True)
    plain = replace(weighed, weighs=False, known={})
    assert weighed.better(found, base)
    assert not plain.better(found, base)
    assert not weighed.better(base, found)


@pytest.mark.parametrize("seed", [301_004, 301_009])
def test_the_instants_of_jumps_do_not_hide_what_is_small_beside_them(seed: int) -> None:
    """A command jumps anywhere within a sample: what a free run misses there says nothing for or against an effect."""
    outcome = play(Trial(seed, ("inflow",), 1.0, "small", "telegraph", 0.9))
    columns = dict(outcome.recording.columns)
    run = Run("jumping", outcome.recording.time, columns["yaw_rate"], columns["torque"], {})
    problem = pose([run], outcome.inertia, [])
    base = nothing(problem)
    found = settle(problem, [(catalogue()["inflow"], (), ())], base)
    proof = Validation.of(problem, None, quick=True)
    assert proof.better(found, base)
    assert not proof.better(base, found)


def test_a_free_run_knows_the_command_and_the_turn_before_it() -> None:
    """From the middle of a recording it goes on with the thrust and the water as the turn before has left them."""
    terms = (Term("torque_lag", "moment", (2.0,)), Term("memory", "linear", (-40.0,), (0.2, 8.0)))
    model = replace(RUBBING, terms=terms)
    signals = under(60.0 * np.sin(0.6 * instants(120.0)))
    index, rate = model.simulate(signals, 0.05)
    signals = replace(signals, rate=rate[index])
    later = [slice(1000, 1400), slice(1500, 2400)]
    whole = np.concatenate([signals.rate[span] for span in later])
    known = model.simulate(signals, 0.05, later)[1]
    forgotten = model.simulate(signals.pieces(later), 0.05)[1]
    assert np.max(np.abs(known - whole)) < 1e-6 + 0.002 * np.max(np.abs(whole))
    assert np.max(np.abs(forgotten - whole)) > 0.05 * np.max(np.abs(whole))


def test_several_models_run_side_by_side_as_each_does_alone() -> None:
    """The folds of a proof: other inertia, drag, friction, water and spans, and none sees the others. The first two are
    alike but for their coefficients and their drag."""
    terms = (Term("memory", "co-rotating", (-30.0,), (0.2, 8.0)), Term("coulomb", "", (FRICTION,), (0.002,)))
    alike = tuple(replace(term, coefficients=(0.5 * term.coefficients[0],)) for term in terms)
    other = (Term("memory", "co-rotating", (-60.0,), (0.1, 3.0)), Term("inertia", "", (90.0,)))
    models = [
        replace(RUBBING, terms=terms),
        replace(RUBBING, damping=200.0 * TABLE, terms=alike),
        replace(RUBBING, damping=150.0 * TABLE, terms=other),
        RUBBING,
    ]
    signals = replace(under(60.0 * np.sin(0.6 * instants(120.0))), rate=0.1 * np.sin(0.6 * instants(120.0) - 1.0))
    spans = [[slice(0, 500), slice(1500, 1900)], [slice(100, 700)], [slice(600, 1400)], [slice(1900, 2400)]]
    index, rate = simulate(models, signals, 0.1, spans)
    alone = [model.simulate(signals, 0.1, each) for model, each in zip(models, spans, strict=True)]
    starts = np.cumsum([0, *(sum(span.stop - span.start for span in each) for each in spans[:-1])])
    assert np.array_equal(index, np.concatenate([i + at for (i, _), at in zip(alone, starts, strict=True)]))
    assert np.allclose(rate, np.concatenate([r for _, r in alone]), rtol=1e-9, atol=1e-12)
    swapped = simulate(models[::-1], signals, 0.1, spans)[1]
    assert np.max(np.abs(swapped - rate)) > 0.01
