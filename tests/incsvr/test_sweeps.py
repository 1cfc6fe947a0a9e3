"""A command that sweeps through the frequencies is told from the whole run, as long as it is nothing else."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from incsvr.effects import Signals
from incsvr.tracing.run import Array
from incsvr.tracing.weak.command import estimated_command
from incsvr.tracing.weak.sweeps import as_sweeps
from incsvr.tracing.weak.weak_form import split

STEP, NOISE, AMPLITUDE, SLOW, FAST = 0.05, 4.0, 60.0, 0.02, 0.2
TIME = np.asarray(STEP * np.arange(14_400), dtype=np.float64)
ONE = np.array([0, TIME.size])
TWO = np.array([0, 6000, TIME.size])


def exponential(part: Array, length: float) -> Array:
    """Cycles of a sweep over a decade, its frequency growing by the same factor in the same time."""
    grown: Array = SLOW * length * ((FAST / SLOW) ** part - 1.0) / np.log(FAST / SLOW)
    return grown


def linear(part: Array, length: float) -> Array:
    """The same, growing by the same amount."""
    grown: Array = length * (SLOW * part + 0.5 * (FAST - SLOW) * part**2)
    return grown


def sweeps(law: Callable[[Array, float], Array], length: float, *, joined: bool) -> Array:
    """Sweeps one after another; `joined` without a jump from one to the next."""
    cycles = law(TIME % length / length, length)
    if joined:
        cycles = cycles + np.floor(TIME / length) * law(np.ones(1), length)
    command: Array = 2.0 + AMPLITUDE * np.sin(2.0 * np.pi * cycles + 0.7)
    return command


def signals(command: Array, start: Array = ONE) -> Signals:
    torque = command + NOISE * np.random.default_rng(3).normal(size=command.size)
    return Signals(STEP, start.astype(np.intp), TIME, np.zeros_like(torque), torque, scale=2.5)


@pytest.mark.parametrize("law", [exponential, linear])
@pytest.mark.parametrize("length", [170.0, 720.0])
@pytest.mark.parametrize("joined", [True, False])
def test_a_sweep_is_told_to_a_fraction_of_its_noise(
    law: Callable[[Array, float], Array], length: float, joined: bool
) -> None:
    command = sweeps(law, length, joined=joined)
    found = as_sweeps(signals(command))
    error = np.abs(found - command)
    assert np.median(error) < 0.1 * NOISE
    assert np.mean(error > NOISE) < 0.02  # near the instants at which a sweep begins anew, and at the ends
    blocks = split(ONE.astype(np.intp), 8, STEP)
    known = estimated_command(signals(command), blocks)
    assert known.parametric_command is not None
    assert known.exact


def test_each_run_has_a_sweep_of_its_own() -> None:
    command = np.concatenate(
        [sweeps(linear, 400.0, joined=True)[: TWO[1]], sweeps(exponential, 250.0, joined=True)[TWO[1] :]]
    )
    error = np.abs(as_sweeps(signals(command, TWO)) - command)
    assert np.median(error) < 0.1 * NOISE


@pytest.mark.parametrize("of", ["telegraph", "many tones", "noise", "nothing"])
def test_what_is_no_sweep_is_told_as_its_mean(of: str) -> None:
    random = np.random.default_rng(4)
    periods = np.geomspace(6.0, 60.0, 7)
    command = {
        "telegraph": AMPLITUDE * np.repeat(random.choice([-1.0, 1.0], 60), 240),
        "many tones": 20.0 * np.sum(np.sin(2.0 * np.pi * TIME[:, None] / periods + random.uniform(0, 6, 7)), axis=1),
        "noise": np.zeros_like(TIME),
        "nothing": np.full_like(TIME, 5.0),
    }[of]
    found = as_sweeps(signals(command))
    np.testing.assert_allclose(found, np.mean(found))


def test_a_sweep_is_foretold_no_better_than_its_noise_without_it() -> None:
    """Why it is worth telling: six earlier blocks do not foretell a frequency that changes."""
    command, blocks = sweeps(exponential, 170.0, joined=True), split(ONE.astype(np.intp), 8, STEP)
    seen = signals(command)
    missed = np.std(blocks.mean(command) - estimated_command(seen, blocks).predicted_torque)
    assert missed > 10.0 * np.std(blocks.mean(as_sweeps(seen) - command))
