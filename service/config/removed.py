"""Keys of the configuration that left: each is refused with one sentence that names what to do instead."""

from __future__ import annotations

from collections.abc import Mapping

REMOVED: Mapping[str, str] = {
    "learner.near": "leave the line out: over several velocities the policy weighted learns, which needs none",
}
"""By the key with its sections."""
