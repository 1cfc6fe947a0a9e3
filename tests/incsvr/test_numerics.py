"""What every room computes with."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from incsvr.numerics import cell_means, integral_at, robust_deviation, root_mean_square, running_integral

STAMPS = np.array([0.0, 1.0, 3.0, 3.5])
VALUES = np.array([2.0, -1.0, 4.0, 0.0])


def test_gross_errors_do_not_move_the_robust_deviation() -> None:
    values = np.random.default_rng(1).normal(0.0, 2.0, 20_000)
    values[:1000] = 1e6
    assert robust_deviation(values) == pytest.approx(2.0, rel=0.1)
    assert root_mean_square(values) > 1e5


@pytest.mark.parametrize("held", [True, False])
def test_means_over_cells_are_those_of_the_course_between_the_stamps(held: bool) -> None:
    edges = np.array([0.0, 0.4, 1.7, 3.2, 3.5])
    fine = np.linspace(0.0, 3.5, 350_001)
    middle = 0.5 * (fine[1:] + fine[:-1])
    course = VALUES[np.searchsorted(STAMPS, middle, side="right") - 1] if held else np.interp(middle, STAMPS, VALUES)
    expected = [course[(middle > low) & (middle < high)].mean() for low, high in pairwise(edges)]
    assert cell_means(STAMPS, VALUES, edges, held) == pytest.approx(expected, abs=1e-4)


def test_the_integral_goes_on_beyond_the_ends() -> None:
    assert integral_at(STAMPS, VALUES, STAMPS, False) == pytest.approx(running_integral(STAMPS, VALUES))
    before, after = integral_at(STAMPS, VALUES, np.array([-1.0, 5.0]), False)
    assert before == pytest.approx(-3.5)  # the line 2 − 3 t goes on
    assert after == pytest.approx(running_integral(STAMPS, VALUES)[-1])  # the last value, 0, lasts
