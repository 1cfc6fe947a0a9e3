"""The axes of one vehicle that a process learns together: a line for each, and the one that a browser looks at."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import Any

from incsvr.plant.axes import AXES
from viewer.page.learner import Learner


class VehicleAxes:
    """The learners of a vehicle's axes; `state` may be called from any thread.

    Args:
        first: the learner that the page was started for; its health names the others.
    """

    def __init__(self, first: Learner) -> None:
        self._first = first
        self._lock = threading.Lock()
        self._others: dict[str, Learner] = {}

    def state(self, axis: str | None) -> dict[str, Any]:
        """Everything that the page shows of an axis, or of the first learner, with a line for each axis in `axes`."""
        told = self._first.state()
        learners = self._learners(told)
        shown = learners[axis].state() if axis in learners else told
        lines = {name: _line(learner.words, learner.state()) for name, learner in learners.items()}
        return {**shown, "vehicle": told.get("health", {}).get("vehicle", ""), "axes": lines}

    def _learners(self, told: Mapping[str, Any]) -> dict[str, Learner]:
        """The learner of each axis that health names; while the first one is away, those that it named before."""
        with self._lock:
            for axis, prefix in told.get("health", {}).get("axes", {}).items():
                if axis in AXES and axis not in self._others:
                    same = prefix == told["prefix"]
                    self._others[axis] = self._first if same else self._first.beside(prefix, AXES[axis])
            return dict(self._others)


def _line(words: Mapping[str, str], state: Mapping[str, Any]) -> dict[str, Any]:
    """What the page shows of an axis in one line."""
    health = state.get("health")
    if state.get("away") or health is None:
        return {"level": "AWAY", "learning": "", "value": None, "unit": words["rate_unit"], "revision": None}
    return {
        "level": health["level"],
        "learning": health["learning"]["state"],
        "value": health["streams"].get("yaw_rate", {}).get("value"),
        "unit": words["rate_unit"],
        "revision": health["revision"],
        "learned": health["learned"],
    }
