"""What the response check makes of the few samples that are left at a recording's end."""

from __future__ import annotations

import numpy as np

from incsvr.checks.response import Residual


def test_of_a_single_sample_nobody_knows_the_torque_a_moment_later() -> None:
    one = np.ones(1)
    left = Residual(one, one, one, one, one, one, (one, one), 0.0)
    assert np.isnan(left.later(np.array([0.0, 0.1]))).all()
    assert left.agility == 0.0
