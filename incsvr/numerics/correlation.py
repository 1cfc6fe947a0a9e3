"""The worth of samples whose errors are correlated: how many independent ones they are in a mean."""

from __future__ import annotations

from incsvr.numerics.arrays import Array

MAX_CORRELATION = 0.95
"""Correlation of the noise of two neighbours up to which it is believed."""


def independent_part(correlation: float) -> float:
    """The number of independent samples per sample, (1 − ρ)/(1 + ρ), where two that follow each other have this ρ."""
    return (1.0 - correlation) / (1.0 + correlation)


def independent_share(error: Array) -> float:
    """The number of independent samples per sample of (n,) errors, in a mean."""
    power = float(error @ error)
    correlation = float(error[1:] @ error[:-1]) / power if power > 0.0 else 0.0
    return independent_part(min(max(correlation, 0.0), MAX_CORRELATION))
