"""The study of several velocities: its methods, and one vehicle of it with the real learner."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.learner import several
from benchmarks.learner.several import Case, examine, gaussian_process, least_squares, report
from incsvr.numerics import Array


@pytest.fixture
def truth() -> tuple[Array, Array]:
    velocity = np.random.default_rng(1).uniform(-0.5, 0.5, (120, 3))
    return velocity, 3.0 * velocity[:, 0] * np.abs(velocity[:, 1]) + velocity[:, 1] * velocity[:, 2]


def test_the_rivals_follow_what_they_can(truth: tuple[Array, Array]) -> None:
    velocity, damping = truth
    for method, allowed in ((least_squares, 1e-9), (gaussian_process, 0.03)):
        predict = method(velocity[:80], damping[:80])
        assert np.abs(predict(velocity[80:]) - damping[80:]).mean() < allowed


def test_all_methods_of_one_vehicle_stand_in_the_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """The decoupled learner is worse than any that knows the other velocities, and every figure is in the table."""
    monkeypatch.setattr(several, "VECTORS", (60,))
    record = examine(910150)
    errors = record["errors"]
    assert set(errors) == set(several.methods())
    coupled = [errors[name] for name in errors if not name.startswith("decoupled")]
    assert max(coupled) < min(errors["decoupled paper 60"], errors["decoupled weighted 60"])
    told = record["learner"]["several weighted 60"]
    assert told["certified_error"] < 0.01
    assert 0.85 < told["held"] <= 1.0
    speed = {"n": 110, "solve_ms": {"median": 0.6}, "sklearn_svr_fit_ms": 1.2, "ratio_to_sklearn_svr_fit": 2.0}
    text = report(
        {"command": "a command", "date": "a date", "processor": "one", "load_before": 0.0, "first_seed": 910150,
         "records": [record, record | {"seed": None, "split": "a → b"}], "solver": speed}
    )  # fmt: skip
    for name, error in errors.items():
        assert f"| {name} | {error:.2f} |" in text
    assert "| a → b |" in text


def test_a_case_is_judged_by_the_true_damping_of_another_run() -> None:
    case = Case.simulated(910151)
    assert case.truth.shape == case.unseen.yaw_rate.shape
    noise = case.unseen.damping - case.truth
    assert 1.0 < np.std(noise) < 6.0
    assert abs(np.mean(noise)) < 1.0
    assert not np.array_equal(case.fitted.yaw_rate[:50], case.unseen.yaw_rate[:50])
