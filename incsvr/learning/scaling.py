"""The paper's settings in the units of another vehicle or axis."""

from __future__ import annotations

from incsvr.learning.iteration import Settings

PAPER_RATE, PAPER_TORQUE = 0.25, 100.0
"""The range for which the paper's settings were tuned [rad/s], [N m]."""


def scaled_to(fastest: float, damping: float, /, **chosen: object) -> Settings:
    """The paper's settings, where lengths in velocity and in damping are scaled to what the vehicle reaches.

    Args:
        fastest: the largest velocity [rad/s], [m/s].
        damping: the largest damping [N m], [N].
        chosen: settings that are not scaled.
    """
    rate, torque, paper = fastest / PAPER_RATE, damping / PAPER_TORQUE, Settings()
    scaled = {
        "gamma": paper.gamma / rate**2,
        "C": paper.C * torque,
        "epsilon": paper.epsilon * torque,
        "near_rate": paper.near_rate * rate,
        "near_damping": paper.near_damping * torque,
        "rate_range": (paper.rate_range[0] * rate, paper.rate_range[1] * rate),
    }
    return Settings(**{**scaled, **chosen})  # type: ignore[arg-type]
