"""Eq. 5 for any axis of a body with a declared mass matrix: d_i = τ_i − (M ν̇)_i − (C(ν) ν)_i − g_i(η), part by part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from incsvr.numerics import Array
from incsvr.plant.attitude import ATTITUDE, Restoring
from incsvr.plant.axes import AXES, VELOCITIES, Axis, stream_of
from incsvr.plant.mass_and_coriolis import coriolis_force, mass_matrix, products

DECLARED_INERTIA = "declared inertia"
"""Line of the torque ledger for the axis's own inertia."""
COUPLED_INERTIA = "coupled inertia"
"""Line of the torque ledger for what the other velocities take by their changes."""
CORIOLIS = "Coriolis"
"""Line of the torque ledger for what products of velocities take."""
RESTORING = "restoring"
"""Line of the torque ledger for what the attitude takes."""

NO_ANGLES: Mapping[str, Array] = MappingProxyType({})
"""Angles of a body whose attitude nobody knows."""

Motion = Mapping[str, tuple[Array, Array]]
"""Each recorded velocity's name → its values (n,) and its accelerations (n,)."""


@dataclass(frozen=True, slots=True)
class Coupled:
    """One axis of a body, with what is known of its other velocities.

    Attributes:
        axis: whose equation it is.
        mass: M (6, 6), symmetric.
        recorded: names of the other velocities, and of the angles roll and pitch, that are measured; those that are not
            are taken for zero.
        weights: weight and buoyancy; None leaves g(η) out.
        appearing: names of the other velocities that appear in the equation of this axis. They follow from M, and are
            looked up for every sample.
    """

    axis: Axis
    mass: Array
    recorded: tuple[str, ...]
    weights: Restoring | None = None
    appearing: tuple[str, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        own = self._own
        pairs = products(self.mass, own)
        there = (pairs != 0.0).any(axis=0) | (pairs != 0.0).any(axis=1) | (self.mass[own] != 0.0)
        appearing = tuple(name for k, name in enumerate(VELOCITIES) if there[k] and k != own)
        object.__setattr__(self, "appearing", appearing)

    def to_dict(self) -> dict[str, Any]:
        """The fields as plain data for `from_dict`."""
        return {
            "axis": self.axis.name,
            "mass_matrix": self.mass.ravel().tolist(),
            "recorded": list(self.recorded),
            "weights": None if self.weights is None else asdict(self.weights),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any]) -> Coupled:
        """The body whose to_dict gave `data`."""
        weights = None if data["weights"] is None else Restoring(**data["weights"])
        return Coupled(AXES[data["axis"]], mass_matrix(data["mass_matrix"]), tuple(data["recorded"]), weights)

    @property
    def inertia(self) -> float:
        """M_ii [kg] or [kg m²]."""
        return float(self.mass[self._own, self._own])

    @property
    def velocities(self) -> tuple[str, ...]:
        """The other velocities that appear in the equation of this axis and are recorded."""
        return tuple(name for name in self.appearing if name in self.recorded)

    @property
    def angles(self) -> tuple[str, ...]:
        """The angles, of roll and pitch, that change what weight and buoyancy do along this axis, and are recorded."""
        return tuple(name for name in self._turning() if name in self.recorded)

    @property
    def coupled_to(self) -> tuple[str, ...]:
        """The measured velocities whose change takes of the axis's torque."""
        return tuple(name for name in self.velocities if self.mass[self._own, VELOCITIES.index(name)] != 0.0)

    @property
    def missing(self) -> tuple[str, ...]:
        """Velocities and angles that appear and are not recorded."""
        return tuple(name for name in (*self.appearing, *self._turning()) if name not in self.recorded)

    @property
    def streams(self) -> tuple[str, ...]:
        """Under what names the measured ones come beside the two streams of the axis."""
        return (*(stream_of(self.axis, name) for name in self.velocities), *self.angles)

    def coriolis(self, rate: Array, others: Mapping[str, Array]) -> Array:
        """(C(ν) ν)_i, (n,) [N m], at the axis's own velocity (n,) [rad/s] and the others' (n,) each."""
        velocity = np.zeros((rate.size, 6))
        velocity[:, self._own] = rate
        for name in self.velocities:
            velocity[:, VELOCITIES.index(name)] = others[name]
        return coriolis_force(self.mass, velocity)[:, self._own]

    def coupled_inertia(self, accelerations: Mapping[str, Array]) -> Array | None:
        """(M ν̇)_i without the axis's own share, (n,) [N m]; None where M couples it with nothing that is recorded."""
        parts = [self.mass[self._own, VELOCITIES.index(name)] * accelerations[name] for name in self.coupled_to]
        return np.asarray(np.sum(parts, axis=0)) if parts else None

    def restoring(self, angles: Mapping[str, Array], count: int) -> Array | None:
        """g_i(η), (count,) [N m], at roll and pitch (count,) each [rad], zero where not given; None without weights."""
        if self.weights is None:
            return None
        roll, pitch = (angles.get(name, np.zeros(count)) for name in ATTITUDE)
        return self.weights.force(roll, pitch)[:, self._own]

    def parts(self, rate: Array, motion: Motion, angles: Mapping[str, Array] = NO_ANGLES) -> dict[str, Array]:
        """The torques beside the axis's own inertia and damping, (n,) each [N m].

        Args:
            rate: the axis's own velocity (n,) [rad/s].
            motion: the other velocities.
            angles: roll and pitch (n,) each [rad], as far as they are measured.
        """
        found = {CORIOLIS: self.coriolis(rate, {name: value for name, (value, _) in motion.items()})}
        inertial = self.coupled_inertia({name: rise for name, (_, rise) in motion.items()})
        if inertial is not None:
            found[COUPLED_INERTIA] = inertial
        restoring = self.restoring(angles, rate.size)
        return found if restoring is None else {**found, RESTORING: restoring}

    def driving(self, motion: Motion, angles: Mapping[str, Array], count: int) -> tuple[Array, Array]:
        """a and b, (count,) each, of a + b r: the same parts for any velocity r of the axis itself.

        ν^T C(ν) ν = 0, so that no square of the own velocity is in its own equation.
        """
        at_rest, moving = (
            np.sum(list(self.parts(np.full(count, rate), motion, angles).values()), axis=0) for rate in (0.0, 1.0)
        )
        return at_rest, moving - at_rest

    @property
    def _own(self) -> int:
        return VELOCITIES.index(self.axis.rate)

    def _turning(self) -> tuple[str, ...]:
        if self.weights is None:
            return ()
        still, turned = np.zeros(2), np.array([0.0, 0.5])
        either = {"roll": (turned, still + 0.5), "pitch": (still + 0.5, turned)}
        return tuple(name for name, at in either.items() if np.ptp(self.weights.force(*at)[:, self._own]) > 0.0)
