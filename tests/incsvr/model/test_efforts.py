"""Mean efforts of steps against fine numerical integrals of the curve that runs through the samples."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from incsvr.model.efforts import Stage, means, root
from incsvr.numerics import Array

STAMPS = np.sort(np.random.default_rng(5).uniform(0.0, 10.0, 60))
VALUES = np.random.default_rng(6).normal(0.0, 5.0, 60)
EDGES = np.asarray(np.arange(-1.0, 12.0, 0.13))
"""From before the first stamp until after the last."""
FINE = 400
"""Points of the integral in a step."""


def curve(way: str) -> Callable[[Array], Array]:
    """The effort at any instant."""
    if way == "hold":
        return lambda t: VALUES[np.clip(np.searchsorted(STAMPS, t, side="right") - 1, 0, None)]
    if way == "linear":
        return lambda t: np.asarray(np.interp(t, STAMPS, VALUES))
    smooth = PchipInterpolator(STAMPS, VALUES)
    return lambda t: np.asarray(smooth(np.clip(t, STAMPS[0], STAMPS[-1])))


def fine(way: str, shift: float) -> tuple[Array, Array]:
    """Instants in the middle of fine cells over all steps, and the effort that acts there."""
    step = EDGES[1] - EDGES[0]
    t = EDGES[0] + step / FINE * (np.arange(FINE * (EDGES.size - 1)) + 0.5)
    return t, curve(way)(t - shift)


@pytest.mark.parametrize("way", ["hold", "linear", "smooth"])
@pytest.mark.parametrize("shift", [0.0, 0.217, -0.08])
def test_the_mean_of_each_step_is_the_integral_of_the_curve(way: str, shift: float) -> None:
    expected = fine(way, shift)[1].reshape(-1, FINE).mean(axis=1)
    found = means((STAMPS, VALUES), EDGES, way, Stage(shift=shift), 10.0)
    # a jump falls anywhere within one of 400 cells: at most 20 / 400
    assert np.abs(found - expected).max() < (0.05 if way == "hold" else 2e-3)


def test_a_lag_follows_the_means_exactly() -> None:
    """The means over steps of x of T ẋ = u − x, which is at rest on the first u, the mean of each step."""
    lag, shift, step = 0.4, 0.05, float(EDGES[1] - EDGES[0])
    inputs = means((STAMPS, VALUES), EDGES, "linear", Stage(shift=shift), 10.0)
    state, expected, small = float(inputs[0]), [], step / 4000
    for u in inputs.tolist():
        course = u + (state - u) * np.exp(-(np.arange(4000) + 0.5) * small / lag)
        expected.append(course.mean())
        state = u + (state - u) * float(np.exp(-step / lag))
    found = means((STAMPS, VALUES), EDGES, "linear", Stage(shift=shift, lag=lag), 10.0)
    assert found == pytest.approx(np.array(expected), abs=1e-6)


def test_rotors_that_lag_in_speed_push_with_its_square() -> None:
    """Euler's method in small steps: T ṅ = √u − n, and the thrust n |n|, whose means lack the ripple within a step."""
    lag, fine_steps = 0.4, 400
    inputs = means((STAMPS, VALUES), EDGES, "hold", Stage(), 10.0)
    speed, expected, small = float(root(inputs[:1])[0]), [], float(EDGES[1] - EDGES[0]) / fine_steps
    for u in np.repeat(root(inputs), fine_steps).tolist():
        expected.append(speed * abs(speed))
        speed += small / lag * (u - speed)
    found = means((STAMPS, VALUES), EDGES, "hold", Stage(spin=lag), 10.0)
    assert found == pytest.approx(np.array(expected).reshape(-1, fine_steps).mean(axis=1), abs=0.02 * np.ptp(inputs))
    assert np.ptp(found - means((STAMPS, VALUES), EDGES, "hold", Stage(lag=lag), 10.0)) > 0.1 * np.ptp(inputs)
    assert means((STAMPS, VALUES), EDGES, "hold", Stage(spin=1e-9), 10.0) == pytest.approx(inputs, abs=1e-6)


def test_static_stages_act_on_the_samples_in_their_order() -> None:
    stage = Stage(exponent=2.0, dead=0.5, limit=6.0, reverse=0.7)
    demanded = np.array([-10.0, -5.0, -1.0, 0.0, 1.0, 5.0, 8.0, 10.0])
    assert stage.static(demanded, 10.0) == pytest.approx([-4.2, -1.4, 0.0, 0.0, 0.0, 2.0, 5.9, 6.0])


@pytest.mark.parametrize(
    "stage",
    [Stage(exponent=1.3), Stage(dead=2.0), Stage(gap=2.0), Stage(limit=7.0), Stage(sag=9.0), Stage(reverse=0.7),
     Stage(exponent=0.8, gap=1.5, sag=8.0, reverse=1.2)],
)  # fmt: skip
def test_what_a_stage_makes_of_an_effort_is_undone(stage: Stage) -> None:
    made = stage.static(np.linspace(-6.0, 6.0, 40), 10.0)
    reached = stage.static(stage.undone(made, 10.0), 10.0)
    jump = 0.625 * (stage.gap or 0.0)  # nothing makes the thrust within it: the nearer end is asked for
    assert np.abs(reached - made).max() <= jump + 1e-9
