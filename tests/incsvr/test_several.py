"""Damping over several velocities: the kernel that is zero at rest, the drag, which samples stay, what is learned."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from incsvr.checks import Vehicle
from incsvr.errors import BadInput
from incsvr.learning import checked_learner
from incsvr.learning.drag import Drag, Several
from incsvr.learning.kernel import columns, rbf, rbf_at_rest
from incsvr.learning.learner import Iteration, Settings, State, start, step
from incsvr.numerics import Array
from incsvr.signals.samples import Samples
from service.recordings.samples_from_recording import samples_of
from simulator import leng
from simulator.vehicles import Vehicle as Body
from tests import worlds
from tests.incsvr.learning import batches, rms, run
from tests.planar import planar, yaw_damping

OTHERS = ("surge", "sway")


@cache
def vehicle(seed: int = 910104) -> tuple[Body, Samples, Samples]:
    """A simulated vehicle with coupled damping, its samples, and those of another run of it."""
    body = planar(seed)
    signals = replace(leng.SIGNALS, inertia=body.inertia)
    runs = [worlds.planar(seed, 400.0, run) for run in (1, 2)]
    there, here = (samples_of(each, signals, None, None, OTHERS)[0] for each in runs)
    return body, there, here


@cache
def learned(others: tuple[str, ...] = OTHERS, capacity: int = 60) -> tuple[State, list[Iteration]]:
    return run(Settings(others=others, capacity=capacity), vehicle()[1])


def truth(samples: Samples) -> Array:
    u, v = samples.channels["surge"], samples.channels["sway"]
    return yaw_damping(vehicle()[0], u, v, samples.yaw_rate, with_munk=True)


def test_the_kernel_at_rest_is_the_gaussian_one_that_knows_the_origin() -> None:
    x = 0.3 * np.random.default_rng(1).normal(size=(60, 3))
    whole = rbf(np.vstack((np.zeros(3), x)), np.vstack((np.zeros(3), x)), 10.0)
    known = whole[1:, 1:] - np.outer(whole[1:, 0], whole[0, 1:]) / whole[0, 0]
    at_rest = rbf_at_rest(x, x, 10.0)
    np.testing.assert_allclose(at_rest, known, atol=1e-14)
    assert not rbf_at_rest(np.zeros((1, 3)), x, 10.0).any()
    low_rank = columns(x, 10.0, vanishing=True)
    np.testing.assert_allclose(low_rank.T @ low_rank, at_rest, atol=1e-12)


@pytest.mark.parametrize(("own", "others"), [("yaw_rate", OTHERS), ("sway", ("surge", "body_yaw_rate")),
                                             ("surge", ("sway", "body_yaw_rate"))])  # fmt: skip
def test_the_derivative_by_the_own_velocity_is_that_of_drag_and_kernels(own: str, others: tuple[str, ...]) -> None:
    rng = np.random.default_rng(11)
    fastest = np.array([0.3, 1.5, 0.8])
    drag = rng.normal(size=Drag.of(own, others).damps.size) * 20.0
    model = Several(own, others, fastest * rng.uniform(-1.0, 1.0, (30, 3)), fastest, drag)
    at, weight = 2.0 * fastest * rng.uniform(-1.0, 1.0, (50, 3)), 30.0 * rng.normal(size=30)
    step = np.array([1e-6, 0.0, 0.0])
    rise = model.value(at + step, 10.0, weight) - model.value(at - step, 10.0, weight)
    np.testing.assert_allclose(model.derivative(at, 10.0, weight), rise / 2e-6, rtol=1e-5, atol=1e-3)


@pytest.mark.parametrize(("own", "others"), [("yaw_rate", OTHERS), ("sway", ("surge", "body_yaw_rate")),
                                             ("surge", ("sway", "body_yaw_rate"))])  # fmt: skip
def test_the_drag_knows_that_port_is_the_mirror_of_starboard(own: str, others: tuple[str, ...]) -> None:
    u = np.random.default_rng(3).uniform(-1.0, 1.0, (20, 3))
    lateral = np.array([-1.0 if name != "surge" else 1.0 for name in (own, *others)])
    drag = Drag.of(own, others)
    there, mirrored = drag.terms(u), drag.terms(u * lateral)
    np.testing.assert_array_equal(mirrored, lateral[0] * there)
    assert not drag.terms(np.zeros((1, 3))).any()
    assert drag.damps.size == there.shape[1]
    assert np.linalg.matrix_rank(drag.terms(np.random.default_rng(4).normal(size=(200, 3)))) == there.shape[1]


def test_coupled_damping_is_learned_that_one_velocity_cannot_tell() -> None:
    unseen = vehicle()[2]
    surface, curve = (learned(others)[0].model for others in (OTHERS, ()))
    said = surface.at(unseen)
    error, alone = rms(said.damping - truth(unseen)), rms(curve.at(unseen).damping - truth(unseen))
    assert error < 0.3 * alone
    assert surface.support_rate.size <= 60
    assert surface.certified_error < 0.01
    assert surface.over(np.zeros((1, 3))).damping.tolist() == [0.0]
    assert 0.85 < np.mean(np.abs(said.damping - unseen.damping) < 1.96 * said.sigma) <= 1.0
    assert 0.0 < said.extrapolated.mean() < 0.5


def test_where_nothing_was_driven_it_extrapolates_and_is_unsure() -> None:
    model = learned()[0].model
    assert model.several is not None
    known = model.several.velocity[:5]
    far = np.array([[0.1, 5.0, 0.0], [0.1, 0.5, 3.0], [1.5, 0.5, 0.0]])
    assert not model.over(known).extrapolated.any()
    said = model.over(far)
    assert said.extrapolated.all()
    assert (said.doubt > 2.0 * model.over(known).doubt.max()).all()
    assert np.isfinite(said.damping).all()
    assert np.abs(said.damping[:2]).max() < 5.0 * np.abs(model.support_damping).max()


def test_samples_without_one_of_its_velocities_and_a_state_over_others_are_refused() -> None:
    samples = vehicle()[1].take(slice(0, 50))
    with pytest.raises(BadInput, match="a batch lacks sway"):
        step(
            Settings(others=OTHERS), start(Settings(others=OTHERS)), replace(samples, channels={"surge": samples.time})
        )
    state = learned()[0]
    for settings in (Settings(), Settings(others=("surge",))):
        with pytest.raises(BadInput, match="learned over surge, sway"):
            step(settings, state, samples)


def test_the_checks_see_a_torque_that_is_reversed_and_no_fault_in_sound_motion() -> None:
    body, samples, unseen = vehicle()
    settings = Settings(policy="weighted", others=OTHERS)
    known = Vehicle(body.inertia, settings.rate_range, leng.SIGNALS.smoothing)
    state = checked_learner.begin(settings)
    for batch in batches(samples):
        state, verdict, _ = checked_learner.learn(settings, known, state, batch)
        assert verdict.learn, verdict.findings
    turned = {name: -values if name.startswith("torque") else values for name, values in unseen.raw.items()}
    inertial = unseen.raw["torque"] - unseen.damping
    reversed_torque = replace(unseen, damping=-unseen.raw["torque"] - inertial, raw=turned)
    verdicts = []
    for batch in batches(reversed_torque.take(slice(0, 200))):
        state, verdict, _ = checked_learner.learn(settings, known, state, batch)
        verdicts.append(verdict)
    assert not any(verdict.learn for verdict in verdicts[1:])
