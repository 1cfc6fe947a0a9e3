"""What a preset says of the bus and of the vehicle where the configuration says nothing: its file goes before it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

ROUTER = "tcp/127.0.0.1:7447"
"""Where the router of BlueOS, of rmw_zenoh and of a Keelson vessel listens; the learner is one more client of it."""
_ROUTED = ("blueos", "ros2", "keelson")
_PLACES = ("listen", "connect", "zenoh_file")
_BLUEROV: dict[str, Any] = {
    # A six-thruster ROV: I from a published identification, the lengths scaled from Leng's ±0.25 rad/s and ±100 N m.
    "vehicle": {
        "name": "bluerov",
        "inertia": 1.125,
        "rate_range": (-1.8, 1.8),
        "rate_limit": 6.0,
        "torque_limit": 40.0,  # four T200 at 20 V turn it with 39 N m
    },
    # Two periods of an ATTITUDE of 20 Hz; of 10 Hz the filter follows by itself.
    "signals": {"sample_period": 0.4, "smoothing": 0.1},
    "learner": {"gamma": 0.2, "C": 60.0, "epsilon": 0.006, "near_rate": 0.07, "near_damping": 0.3},
}


def defaults(values: Mapping[str, Any]) -> dict[str, Any]:
    """What the preset of a configuration says beside the configuration's own values."""
    inputs = values.get("inputs")
    preset = inputs.get("preset") if isinstance(inputs, Mapping) else None
    found = dict(_BLUEROV) if preset == "blueos" else {}
    bus = values.get("bus")
    if preset in _ROUTED and not (isinstance(bus, Mapping) and any(bus.get(name) for name in _PLACES)):
        found["bus"] = {"connect": ROUTER}
    return found
