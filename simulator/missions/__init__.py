"""Ordinary missions, for the learner and the tracer: what vehicles do all day, in water that moves them."""

from __future__ import annotations

from simulator.missions.hidden import FULL_SIZE
from simulator.missions.mission import GYRO_NOISE, KINDS, Mission, Outcome, play
from simulator.missions.motion import Motion
from simulator.missions.vehicles import VEHICLES, Vehicle

__all__ = ["FULL_SIZE", "GYRO_NOISE", "KINDS", "VEHICLES", "Mission", "Motion", "Outcome", "Vehicle", "play"]
