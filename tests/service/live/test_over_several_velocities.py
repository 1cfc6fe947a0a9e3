"""Live tracing beside a learner over several velocities: the effect is found, and not what the surface knows."""

from __future__ import annotations

import pytest

from benchmarks.live_watch import watch
from incsvr.numerics import root_mean_square as rms
from service.config.configuration import Config
from service.recordings.recording import Recording, from_table
from tests import worlds
from tests.planar import planar
from tests.service.conftest import configured, cut

SEED = 910104
REVERSE_EFFICIENCY = 0.6


@pytest.fixture(scope="module")
def weak_in_reverse() -> Recording:
    """A vehicle in the plane whose reverse thrust is weaker than its command, from the beginning."""
    run = cut(worlds.planar(SEED, 460.0), 420.0)
    columns = {name: values.copy() for name, values in run.columns.items()}
    torque = columns["torque"]
    torque[torque < 0.0] /= REVERSE_EFFICIENCY
    return from_table(run.name, run.time, columns)


def over(*inputs: str) -> Config:
    return configured(
        vehicle__inertia=planar(SEED).inertia, learner__policy="weighted", learner__inputs=inputs,
        tracing__live="adopt", tracing__window=240.0, tracing__proof=60.0,
    )  # fmt: skip


@pytest.mark.slow
def test_an_effect_is_promoted_and_the_surface_learned_anew(weak_in_reverse: Recording) -> None:
    seen = watch(over("yaw_rate", "surge", "sway"), weak_in_reverse)
    assert [(step["step"], step["effect"]) for step in seen.history] == [
        ("suspected", "torque_asymmetry"),
        ("promoted", "torque_asymmetry"),
    ]
    active = seen.state.active
    assert active is not None
    assert active.effects[0]["parameters"]["reverse_efficiency"] == pytest.approx(REVERSE_EFFICIENCY, abs=0.05)
    time, left = seen.residuals
    assert rms(left[time > 365.0]) < 0.8 * rms(left[(time > 200.0) & (time < 300.0)])
