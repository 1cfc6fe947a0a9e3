"""The presets of kinds of vehicles: each finds a mapping among the topics, and names what is missing."""

from __future__ import annotations

from service.inputs.presets.proposal import Observation, Proposal, propose

__all__ = ["Observation", "Proposal", "propose"]
