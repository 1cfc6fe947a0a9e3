"""A table in even steps is what interpolation says, whatever is asked of it."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects.even_table import EvenTable

AT = np.linspace(-0.7, 1.9, 27)
VALUES = np.random.default_rng(0).normal(size=AT.size)
TABLE = EvenTable(float(AT[0]), float(AT[1] - AT[0]), VALUES)


@pytest.mark.parametrize(
    "asked",
    [
        pytest.param(np.random.default_rng(1).uniform(-0.7, 1.9, (2, 50)), id="within, of any shape"),
        pytest.param(AT, id="its own arguments"),
        pytest.param(np.array([-1e9, -0.7 - 1e-9, 1.9 + 1e-9, 1e9, np.inf, -np.inf]), id="beyond its ends"),
    ],
)
def test_it_is_the_interpolation(asked: np.ndarray) -> None:
    np.testing.assert_allclose(TABLE(asked), np.interp(asked, AT, VALUES), atol=1e-12)


def test_what_is_no_number_is_in_some_cell() -> None:
    """A run that diverged must not raise, nor warn."""
    assert TABLE(np.array([np.nan]))[0] in (VALUES[0], VALUES[-1])
