"""Noise that lasts: each value keeps a part of the one before."""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array


def lasting_noise(value: float, kept: float, kicks: Array) -> Array:
    """(n,) values xₖ = kept · xₖ₋₁ + kickₖ that follow a first one, which is not among them."""
    values = list[float]()
    for kick in kicks.tolist():
        value = kept * value + kick
        values.append(value)
    return np.array(values)
