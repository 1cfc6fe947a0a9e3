"""What vehicles of a kind speak: each preset finds the mapping in what is there, and says what is missing."""

from __future__ import annotations

from service.inputs.presets.proposal import Observation, Proposal, propose

__all__ = ["Observation", "Proposal", "propose"]
