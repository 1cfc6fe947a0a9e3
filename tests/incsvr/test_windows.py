"""What the tracer minimises: cells of recordings, errors of predictions over windows, and their slopes."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects import catalogue
from incsvr.tracing import innovations, windows
from incsvr.tracing.cells import Cut, cut
from incsvr.tracing.errors import Problem
from incsvr.tracing.hypothesis import Hypothesis, starts
from incsvr.tracing.torque_nature import TorqueNature
from tests.incsvr.turning import INERTIA, PERIOD, command, instants, turning

HELD = TorqueNature(held=True, noisy=False)
TIME = instants(300.0)
WINCH = np.sin(TIME / 7.0)


def posed(form: str = "windows") -> Problem:
    run = turning(1, command(1, TIME), channels={"winch": WINCH})
    pose = windows.pose if form == "windows" else innovations.pose
    return pose([run], INERTIA, ["winch"], HELD)


def with_effect(problem: Problem, key: str) -> Hypothesis:
    """The effect at a start of its own, with coefficients that matter."""
    part = list(starts(catalogue(["winch"])[key], problem.cells.signals))[-1]
    size = {"memory/linear": -60.0, "inertia": 30.0, "modulation:winch/damping": 0.2}.get(key, 2.0)
    if part.coefficients and not part.effect.from_start:
        part = part.moved(np.concatenate([np.full(part.coefficients, size), part.vector[part.coefficients :]]))
    return problem.start.with_part(part)


def test_a_held_torque_is_its_exact_mean_in_each_cell() -> None:
    run = turning(1, command(1, TIME))
    cells = cut([run], INERTIA, [], Cut(0.17, HELD, 3.0))
    fine = np.repeat(run.torque, 100)
    edges = np.rint(cells.signals.time / (PERIOD / 100)).astype(int)
    expected = [fine[a : a + 340].mean() for a in edges[5:50]]
    np.testing.assert_allclose(cells.signals.torque[5:50], expected, atol=0.5)


@pytest.mark.parametrize("form", ["windows", "innovations"])
@pytest.mark.parametrize(
    "key",
    ["bias_torque", "inertia", "torque_lag/moment", "torque_delay", "torque_asymmetry", "inflow", "coulomb",
     "memory/linear", "drag_drift", "tether", "modulation:winch/damping", "torque_saturation/smooth limit"],
)  # fmt: skip
def test_analytic_slopes_are_those_of_simulations(key: str, form: str) -> None:
    """Of every free number, against simulations with the number a little larger and a little smaller."""
    problem = posed(form)
    hypothesis = with_effect(problem, key)
    _, response = problem.errors(hypothesis)
    analytic = response.jacobian(hypothesis)
    vector = hypothesis.vector
    least = 1e-3 * float(np.sqrt(np.mean(analytic**2)))
    for k in range(vector.size):
        step = np.zeros(vector.size)
        step[k] = 1e-3 * max(abs(vector[k]), 0.05)
        if k == problem.start.basis.size:
            continue  # the offset's slope leaves out what effects of the motion read of the thrust
        up, down = (problem.errors(hypothesis.moved(vector + side * step))[0] for side in (1.0, -1.0))
        numeric = (up - down) / (2.0 * step[k])
        scale = float(np.sqrt(np.mean(numeric**2)))
        assert np.sqrt(np.mean((analytic[k] - numeric) ** 2)) < 0.2 * scale + least, k


def test_long_recordings_are_thinned_evenly_and_say_so() -> None:
    time = instants(1800.0)
    problem = innovations.pose([turning(3, command(3, time))], INERTIA, [], HELD)
    assert problem.share < 0.5
    begun = problem.cells.signals.time[problem.windows.first]
    assert begun[0] < 100.0
    assert begun[-1] > 1700.0
