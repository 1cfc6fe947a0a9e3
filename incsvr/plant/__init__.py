"""The vehicle: its axes, its thrusters, and Eq. 5 (Section II, IV-A)."""

from __future__ import annotations

from incsvr.plant.motion import damping_moment
from incsvr.plant.thrusters import Thruster, thruster_torque

__all__ = ["Thruster", "damping_moment", "thruster_torque"]
