"""What a model consists of: its vectors with their weights, and what is known of the noise in them."""

from __future__ import annotations

from dataclasses import dataclass, field

from incsvr.learning.excitation import Water
from incsvr.learning.several_velocities.several import Several
from incsvr.learning.spread import Spread
from incsvr.numerics import Array


@dataclass(frozen=True, eq=False)
class Support:
    """The numbers of a model; what it answers is `incsvr.learning.model.Model`."""

    gamma: float  # kernel width γ [(rad/s)⁻²] of κ(x, z) = exp(−γ(x − z)²)
    C: float  # bound on |θ| [N m] and half height of the tube [N m], as configured
    epsilon: float
    support_rate: Array  # (m,) the vectors [rad/s], [N m] and their θ [N m]
    support_damping: Array
    weight: Array
    count: Array  # (m,) how many samples each vector stands for
    sigma: float  # noise level of a damping sample [N m], over all rates
    certified_error: float  # no exact solution differs from this one by more, at any rate [N m]
    correlation: float = 0.0  # of the noise of two samples that follow each other
    water: Water = field(default_factory=Water)  # the motion that was no evidence, because the water made it
    spread: Spread = field(default_factory=lambda: Spread(1.0))  # how the noise follows the yaw rate
    widening: float = 1.0  # by how much fresh samples have disagreed with the curve, in its own doubt; at least 1
    # the further velocities that damping was learned over; None where it was over the own one alone
    several: Several | None = None
