"""Eq. 5 for any axis of a body with a declared mass matrix: d_i = τ_i − (M ν̇)_i − (C(ν) ν)_i − g_i(η), part by part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from incsvr.plant.attitude import Restoring
from incsvr.plant.axes import VELOCITIES, Axis
from incsvr.plant.inertia import coriolis_force, products
from incsvr.samples import Array

DECLARED_INERTIA = "declared inertia"
COUPLED_INERTIA, CORIOLIS, RESTORING = "coupled inertia", "Coriolis", "restoring"
"""Lines of the torque ledger beside that of the axis's own inertia: of the other velocities and of the attitude."""

Motion = Mapping[str, tuple[Array, Array]]
"""Each recorded velocity's name → its values (n,) and its accelerations (n,)."""


@dataclass(frozen=True, slots=True)
class Coupled:
    """One axis of a body, with what is known of its other velocities.

    Attributes:
        axis: whose equation it is.
        mass: M (6, 6), symmetric.
        recorded: names of the other velocities that are measured; those that are not are taken for zero.
        weights: weight and buoyancy, where the attitude is measured; None leaves g(η) out.
    """

    axis: Axis
    mass: Array
    recorded: tuple[str, ...]
    weights: Restoring | None = None

    @property
    def inertia(self) -> float:
        """M_ii [kg] or [kg m²]."""
        return float(self.mass[self._own, self._own])

    @property
    def velocities(self) -> tuple[str, ...]:
        """The other velocities that appear in the equation of this axis and are recorded."""
        return tuple(name for name in self._appearing() if name in self.recorded)

    @property
    def missing(self) -> tuple[str, ...]:
        """Those that appear and are not recorded."""
        return tuple(name for name in self._appearing() if name not in self.recorded)

    def coriolis(self, rate: Array, others: Mapping[str, Array]) -> Array:
        """(C(ν) ν)_i, (n,) [N m], at the axis's own velocity (n,) [rad/s] and the others' (n,) each."""
        velocity = np.zeros((rate.size, 6))
        velocity[:, self._own] = rate
        for name in self.velocities:
            velocity[:, VELOCITIES.index(name)] = others[name]
        return coriolis_force(self.mass, velocity)[:, self._own]

    def coupled_inertia(self, accelerations: Mapping[str, Array]) -> Array | None:
        """(M ν̇)_i without the axis's own share, (n,) [N m]; None where M couples it with nothing that is recorded."""
        parts = [self.mass[self._own, VELOCITIES.index(name)] * accelerations[name] for name in self._coupled_to()]
        return np.asarray(np.sum(parts, axis=0)) if parts else None

    def parts(self, rate: Array, motion: Motion, attitude: tuple[Array, Array] | None = None) -> dict[str, Array]:
        """What takes of τ_i beside the axis's own inertia and damping, (n,) each [N m].

        Args:
            rate: the axis's own velocity (n,) [rad/s].
            motion: the other velocities.
            attitude: roll and pitch (n,) each [rad]; None where they are not measured.
        """
        found = {CORIOLIS: self.coriolis(rate, {name: value for name, (value, _) in motion.items()})}
        inertial = self.coupled_inertia({name: rise for name, (_, rise) in motion.items()})
        if inertial is not None:
            found[COUPLED_INERTIA] = inertial
        if self.weights is not None and attitude is not None:
            found[RESTORING] = self.weights.force(*attitude)[:, self._own]
        return found

    def driving(self, motion: Motion) -> tuple[Array, Array]:
        """a and b, (n,) each, of a + b r: the same parts for any velocity r of the axis itself.

        ν^T C(ν) ν = 0, so that no square of the own velocity is in its own equation.
        """
        count = next((values.size for values, _ in motion.values()), 0)
        at_rest, moving = (
            np.sum(list(self.parts(np.full(count, rate), motion).values()), axis=0) for rate in (0.0, 1.0)
        )
        return at_rest, moving - at_rest

    @property
    def _own(self) -> int:
        return VELOCITIES.index(self.axis.rate)

    def _coupled_to(self) -> tuple[str, ...]:
        return tuple(name for name in self.velocities if self.mass[self._own, VELOCITIES.index(name)] != 0.0)

    def _appearing(self) -> tuple[str, ...]:
        own = self._own
        pairs = products(self.mass, own)
        there = (pairs != 0.0).any(axis=0) | (pairs != 0.0).any(axis=1) | (self.mass[own] != 0.0)
        return tuple(name for k, name in enumerate(VELOCITIES) if there[k] and k != own)
