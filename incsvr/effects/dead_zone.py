"""Dead band of the thrusters."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr

from incsvr.effects.effect import Effect, Term, stack
from incsvr.effects.signals import Array, Signals

STARTS = {"shifted": 9, "step": 24}
"""Half widths that are tried. The command of a controller stays about a step's edge: past it little is explained."""

NARROWEST = 1.5
"""Half width in steps of the recorded torque: of commands about zero a first step holds mostly its smaller half, and
less thrust than it says."""

FAR = 6.0
"""Deviations of the doubt from the edge beyond which there is no doubt on which side the command was."""


class DeadZone(Effect):
    """Nothing comes out for |τ| < w; beyond, either all of τ (`step`) or what exceeds w (`shifted`).

    Inside the band the rate side knows nothing of the command, so the column looks at the expected one. The sharp edge
    of the step would be lost in the doubt of that: the column is what is lost in the mean over the doubt (regression
    calibration: R. J. Carroll et al., Measurement Error in Nonlinear Models, 2006, ch. 4).
    """

    name = "dead_zone"
    sentence = "the thrusters have a dead band: they give nothing while the commanded moment is small"
    source = "D. R. Yoerger, J. G. Cooke, J.-J. E. Slotine, IEEE J. Oceanic Eng. 15(3), 1990"
    acts = "thrust"
    stage = 1
    searched = True
    fixed_coefficient = True
    looks = 12.0

    def __init__(self, variant: str) -> None:
        self.variant = variant

    def starts(self, s: Signals) -> list[tuple[float, ...]]:
        low, high = self.bounds(s)
        return [(float(w),) for w in np.geomspace(low, high, STARTS[self.variant])]

    def bounds(self, s: Signals) -> tuple[float, float]:
        largest = float(np.quantile(np.abs(s.torque), 0.99))
        low = max(0.02 * largest, NARROWEST * s.quantum)
        return low, max(0.5 * largest, low)

    def lost(self, command: Array, width: float) -> Array:
        if self.variant == "shifted":
            return np.clip(command, -width, width)
        return np.where(np.abs(command) < width, command, 0.0)

    def columns(self, s: Signals, inner: tuple[float, ...], coefficients: tuple[float, ...]) -> Array:
        width = inner[-1]

        def lost(c: Array) -> Array:
            if self.variant == "shifted" or s.uncertainty <= 0.0:
                return self.lost(c, width)
            inside = self.lost(c, width)
            near = np.abs(np.abs(c) - width) < FAR * s.uncertainty
            inside[near] = _averaged(c[near], width, s.uncertainty)
            return inside

        return stack(s.over_jumps(s.expected, lost))

    def parameters(self, term: Term, inertia: float) -> dict[str, float]:
        return {"half_width_nm": term.inner[-1]}

    def implausible(self, term: Term, s: Signals) -> str:
        if not 0.5 < term.coefficients[0] < 1.6:
            return f"inside the band {term.coefficients[0]:.0%} of the command would be lost, a dead band loses all"
        return ""

    def thrust(self, command: Array, s: Signals, term: Term) -> Array:
        return command - term.coefficients[0] * s.over_jumps(command, lambda c: self.lost(c, term.inner[-1]))


def _averaged(command: Array, width: float, uncertainty: float) -> Array:
    """What a step's band takes, in the mean over a Gaussian doubt of the command."""
    low, high = (-width - command) / uncertainty, (width - command) / uncertainty
    density = np.exp(-0.5 * low**2) - np.exp(-0.5 * high**2)
    inside: Array = command * (ndtr(high) - ndtr(low)) + uncertainty / np.sqrt(2.0 * np.pi) * density
    return inside
