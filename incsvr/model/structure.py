"""The structure of a model, and its parameters: which axes, rows and stages it has; θ is a vector by name.

mass:surge (logarithm)        mass:sway*yaw_rate         linear@surge, cross_flow:surge@yaw_rate, …
shift:torque [s]              lag:torque, limit:torque, dead:torque, reverse:torque, exponent:torque (logarithms)
time:memory@yaw_rate (logarithm)     gain:surge, drift:surge, fade:surge (logarithms of 1/s): of a predictor
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from incsvr.model.rows import Row
from incsvr.numerics import Array

Theta = Mapping[str, float]
"""The parameters' values by name."""
LOGARITHMS = ("lag", "spin", "drift", "fade", "limit", "sag", "dead", "gap", "reverse", "exponent", "time")
"""Parameters that are positive by nature, whose logarithms are in θ, like those of the masses on the diagonal of M."""
STAGES = ("exponent", "dead", "gap", "limit", "sag", "reverse", "spin", "lag")
"""Stages of an effort, in the order in which it passes them."""

OF_PREDICTOR = ("gain", "drift", "fade")
"""Parameters of a predictor on each axis: gains of a sample on velocity and disturbance, and how fast that fades."""
NO_PRIOR = 1e6
"""Deviation of a prior that tells nothing."""


@dataclass(frozen=True, slots=True)
class Structure:
    """What a model consists of.

    Attributes:
        axes: velocities that it predicts, in the order of ν.
        driven: axes whose effort is recorded.
        rows: terms that are linear in their coefficients.
        tied: whether C(ν) follows from M.
        coupled: pairs of axes between which M has an entry.
        stages: of an effort, by its axis.
        given: inertias that are declared and not fitted: logarithms by axis, entries of M by pair, as `sway*yaw_rate`.
        ways: of an effort between its samples, by axis.
        shift_priors: deviation about zero of the free shift in time [s], by axis; an axis that is not there has none.
        predictor: whether it is corrected by each sample, with a fitted gain, as in closed loop it must be.
        channels: streams that it reads as they were measured.
    """

    axes: tuple[str, ...]
    driven: tuple[str, ...]
    rows: tuple[Row, ...] = ()
    tied: bool = False
    coupled: tuple[tuple[str, str], ...] = ()
    stages: tuple[tuple[str, str], ...] = ()
    given: Mapping[str, float] = field(default_factory=dict)
    ways: Mapping[str, str] = field(default_factory=dict)
    shift_priors: Mapping[str, float] = field(default_factory=dict)
    predictor: bool = False
    channels: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the fitted parameters, in the order of the vector."""
        found = [f"mass:{axis}" for axis in self.axes if axis not in self.given]
        found += [f"mass:{a}*{b}" for a, b in self.coupled if f"{a}*{b}" not in self.given]
        for row in self.rows:
            found.append(row.key)
            if row.follows:
                found.append(f"time:{row.key}")
        found += [f"shift:{axis}" for axis in self.driven if axis in self.shift_priors]
        found += [f"{kind}:{axis}" for kind, axis in self.stages]
        if self.predictor:
            found += [f"{kind}:{axis}" for kind in OF_PREDICTOR for axis in self.axes]
        return tuple(found)

    def bounds(self, name: str) -> tuple[float, float]:
        """(lowest, highest) value of a parameter."""
        if name.startswith("gain:"):
            return 0.0, 1.0
        if name.startswith("fade:"):
            return -9.0, 5.0
        if name.startswith("drift:"):
            return -9.0, 9.0
        if name.startswith("shift:"):  # two deviations are a period: what is more is a delay
            prior = self.prior(name)
            return (-np.inf, np.inf) if prior >= NO_PRIOR else (-2.0 * prior, 2.0 * prior)
        row = next((row for row in self.rows if row.key == name), None)
        return (-np.inf, np.inf) if row is None else (row.low, row.high)

    def prior(self, name: str) -> float:
        """Deviation about zero that a parameter has before any data; infinite where nothing is known."""
        kind, _, axis = name.partition(":")
        return float(self.shift_priors[axis]) if kind == "shift" else np.inf

    def plus(
        self, rows: Sequence[Row] = (), stages: Sequence[tuple[str, str]] = (), free: Sequence[str] = ()
    ) -> Structure:
        """The structure with more; `free` are axes whose inertia is no longer the declared one."""
        return replace(
            self,
            rows=self.rows + tuple(rows),
            stages=self.stages + tuple(stages),
            given={axis: value for axis, value in self.given.items() if axis not in free},
        )

    def masses(self, columns: Mapping[str, Array]) -> Array:
        """M of each column of parameters, (columns, axes, axes)."""
        count, size = next(iter(columns.values())).size, len(self.axes)
        found = np.zeros((count, size, size))
        for i, axis in enumerate(self.axes):
            found[:, i, i] = np.exp(np.clip(columns.get(f"mass:{axis}", self.given.get(axis, 0.0)), -60.0, 60.0))
        for a, b in self.coupled:
            i, j = self.axes.index(a), self.axes.index(b)
            found[:, i, j] = found[:, j, i] = columns.get(f"mass:{a}*{b}", self.given.get(f"{a}*{b}", 0.0))
        return found

    def inertia(self, theta: Theta, axis: str) -> float:
        """The inertia of an axis [kg] or [kg m²]."""
        return float(np.exp(theta.get(f"mass:{axis}", self.given.get(axis, 0.0))))


def is_logarithm(name: str) -> bool:
    """Whether a parameter is in θ as its logarithm."""
    kind, _, rest = name.partition(":")
    return kind in LOGARITHMS or (kind == "mass" and "*" not in rest)
