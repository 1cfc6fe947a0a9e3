"""The regression where the noise turns the vehicle, and with it the columns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from incsvr.tracing.run import Array
from incsvr.tracing.weak.weak_form import Blocks, split
from incsvr.tracing.weak.whitening import fit
from tests.incsvr.turning import PERIOD as STEP
from tests.incsvr.turning import command, instants, turning

INERTIA, DRAG, PERIOD = 350.0, 100.0, 0.5
"""[kg m²], [N m s], of a block [s]."""
STEPS, BLOCKS = 10, 1500
TIME = instants(400.0)


def driven(seed: int, noise: float, memory: float = 0.0) -> tuple[Array, Array, Blocks, Array]:
    """y, the mean rates, blocks, and how the mean rates answer: a vehicle with linear drag that the water turns, too.

    The command jumps every five blocks; the water's moment has the deviation `noise` [N m], and from block to block the
    autocorrelation `memory`.
    """
    random = np.random.default_rng(seed)
    torque = np.repeat(30.0 * random.normal(size=BLOCKS // 5), 5)
    water = lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], random.normal(0.0, noise, BLOCKS))
    moment = np.repeat(torque + water, STEPS)
    kept = np.exp(-DRAG / INERTIA * PERIOD / STEPS)
    rate = np.concatenate([[0.0], lfilter([1.0 - kept], [1.0, -kept], moment / DRAG)])
    blocks = split(np.array([0, rate.size]), STEPS, PERIOD / STEPS)
    mean = blocks.mean(rate)[:, None]
    jacobian = np.stack([np.full_like(mean, 0.5 * PERIOD / INERTIA), np.zeros_like(mean)])
    return torque - INERTIA * blocks.slope(rate), mean, blocks, jacobian


def test_least_squares_underestimates_the_drag_where_the_noise_turns_the_vehicle() -> None:
    """The Jacobian takes away two fifths of that at least, seed for seed."""
    for seed in range(8):
        y, mean, blocks, jacobian = driven(seed, 30.0)
        plain, corrected = (fit(y, mean, blocks, rounds=6, jacobian=t).theta[0] for t in (None, jacobian))
        assert plain < 0.9 * DRAG
        assert abs(corrected - DRAG) < 0.6 * abs(plain - DRAG)


def test_drag_and_inertia_are_right_in_the_mean_where_lasting_noise_turns_the_vehicle() -> None:
    """The weights and the scale are those of the fit with the Jacobian: with those of least squares it went too far."""
    errors = []
    for seed in range(12):
        y, mean, blocks, jacobian = driven(seed, 10.0, memory=0.7)
        torque = np.repeat(30.0 * np.random.default_rng(seed).normal(size=BLOCKS // 5), 5)
        columns = np.column_stack([mean, (torque - y) / INERTIA])  # y holds I₀ Δr/T_b already: nothing is missing
        answers = np.concatenate([jacobian, np.stack([np.full_like(mean, 1.0 / INERTIA), np.zeros_like(mean)])], axis=2)
        drag, inertia = fit(y, columns, blocks, rounds=6, jacobian=answers).theta
        errors.append((drag / DRAG - 1.0, inertia / INERTIA))
    drag_error, inertia_error = np.abs(np.mean(errors, axis=0))
    assert drag_error < 0.04
    assert inertia_error < 0.015


def test_without_noise_that_turns_the_vehicle_the_jacobian_changes_nothing() -> None:
    y, mean, blocks, jacobian = driven(1, 1e-6)
    np.testing.assert_allclose(fit(y, mean, blocks, jacobian=jacobian).theta, DRAG, rtol=1e-4)


def test_the_likelihood_prefers_the_true_drag_to_that_of_least_squares() -> None:
    """With the Jacobian counted at either drag."""
    for seed in range(8):
        y, mean, blocks, jacobian = driven(seed, 30.0)
        plain = fit(y, mean, blocks, rounds=6)
        whole = fit(y, mean, blocks, rounds=6, jacobian=jacobian)
        held = float(np.log1p(jacobian[0, 0, 0] * plain.theta[0])) * blocks.with_history.size
        assert whole.log_likelihood > plain.log_likelihood + held


def test_the_fit_of_strong_narrow_waves_has_converged() -> None:
    """Nearly collinear damping columns once sent it away, and an idle channel gained what it lost."""
    for seed in range(3):
        problem = turning(seed, command(seed, TIME), outside=_waves(seed))
        few, many = (
            fit(problem.y, problem.coarse, problem.blocks, rounds=rounds, jacobian=problem.jacobian).log_likelihood
            for rounds in (6, 60)
        )
        assert abs(few - many) < 1.0


def _waves(seed: int) -> Array:
    """A moment of four narrow bands, periods of 3 to 25 s [N m]."""
    total = np.zeros(TIME.size)
    for k, (period, amplitude) in enumerate(((3.0, 16.0), (9.0, 16.0), (25.0, 16.0), (7.0, 10.0))):
        turn, radius = 2.0 * np.pi * STEP / period, 0.998
        noise = np.random.default_rng([seed, k]).normal(size=TIME.size + 4000)
        band = lfilter([1.0], [1.0, -2.0 * radius * np.cos(turn), radius**2], noise)[4000:]
        total = total + amplitude * band / np.std(band)
    return total


def test_the_fit_holds_where_the_thrust_answers_the_noise_more_than_once() -> None:
    """Two nearly equal columns, answers beyond one: the Jacobian leads to the likelihood's maximum, not out of it."""
    for seed in range(6):
        y, mean, blocks, jacobian = driven(seed, 30.0)
        random = np.random.default_rng(seed)
        command = random.normal(size=len(blocks))
        columns = np.column_stack([mean, command, command + 0.02 * random.normal(size=len(blocks))])
        thrust = 1.5 * np.abs(command)[:, None] - np.array([0.75, 0.7])
        answers = np.concatenate([jacobian, np.stack([thrust, thrust])], axis=2)
        first, last = (fit(y, columns, blocks, rounds=rounds, jacobian=answers) for rounds in (1, 5))
        assert last.log_likelihood > first.log_likelihood


def jumping(seed: int, size: float) -> tuple[Array, Array, Blocks]:
    """Noise u_t = 0.7 u_{t-1} + e, a column that it does not know, and blocks of which every eighth holds a jump.

    A jump adds `size` deviations of e to its own block, and to no other.
    """
    random = np.random.default_rng(seed)
    blocks = split(np.array([0, 4 * BLOCKS + 1]), 4, 0.1)
    jumped = np.arange(BLOCKS) % 8 == 5
    noise = lfilter([1.0], [1.0, -0.7], random.normal(size=BLOCKS)) + size * jumped * random.normal(size=BLOCKS)
    return noise, random.normal(size=(BLOCKS, 1)), replace(blocks, mistimed=12.0 * jumped)


def test_what_jumps_add_is_hardly_colour_and_no_scale() -> None:
    for seed in range(5):
        noise, column, blocks = jumping(seed, 6.0)
        found = fit(noise, column, blocks, rounds=6)
        assert found.ar[0] > 0.45
        assert abs(144.0 * found.jump_noise / 36.0 - 1.0) < 0.35
        deaf = fit(noise, column, replace(blocks, mistimed=np.zeros(BLOCKS)), rounds=6)
        assert deaf.ar[0] < 0.3
        assert found.log_likelihood > deaf.log_likelihood + 200.0


def test_where_jumps_add_nothing_nothing_is_allowed_for() -> None:
    for seed in range(5):
        noise, column, blocks = jumping(seed, 0.0)
        assert fit(noise, column, blocks, rounds=6).jump_noise < 0.5 / 144.0
