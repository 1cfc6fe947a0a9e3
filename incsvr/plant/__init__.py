"""The vehicle: its axes, its thrusters, and Eq. 5 (Section II, IV-A)."""

from __future__ import annotations

from incsvr.plant.motion import Damping, damping_moment, free_run, tabulated
from incsvr.plant.thrusters import Thruster, thruster_torque

__all__ = ["Damping", "Thruster", "damping_moment", "free_run", "tabulated", "thruster_torque"]
