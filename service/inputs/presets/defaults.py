"""The defaults of a preset for bus and vehicle; the configuration overrides them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

ROUTER = "tcp/127.0.0.1:7447"
"""The endpoint at which the router of BlueOS, of rmw_zenoh and of a Keelson vessel listens; the learner is one more
client of it."""
_ROUTED = ("blueos", "ros2", "keelson")
_PLACES = ("listen", "connect", "zenoh_file")
_BLUEROV: dict[str, Any] = {
    # A six-thruster ROV: I from a published identification, the rest as `incsvr fit` scaled it to runs of that vehicle
    # (deploy/bluerov.yaml); the limits leave room for four T200 at 20 V, which turn it with 39 N m.
    "vehicle": {
        "name": "bluerov",
        "inertia": 1.125,
        "rate_range": (-1.7, 1.7),
        "rate_limit": 6.0,
        "torque_limit": 40.0,
    },
    "signals": {"sample_period": 0.4, "smoothing": 0.2},
    "learner": {
        "policy": "weighted",
        "gamma": 0.215,
        "C": 61.2,
        "epsilon": 0.00612,
        "near_rate": 0.0682,
        "near_damping": 0.306,
    },
}


def defaults(values: Mapping[str, Any]) -> dict[str, Any]:
    """The values of a configuration's preset that the configuration does not set itself."""
    inputs = values.get("inputs")
    preset = inputs.get("preset") if isinstance(inputs, Mapping) else None
    found = dict(_BLUEROV) if preset == "blueos" else {}
    bus = values.get("bus")
    if preset in _ROUTED and not (isinstance(bus, Mapping) and any(bus.get(name) for name in _PLACES)):
        found["bus"] = {"connect": ROUTER}
    vehicle = values.get("vehicle")
    if isinstance(inputs, Mapping) and isinstance(inputs.get("thrusters"), Mapping) and isinstance(vehicle, Mapping):
        found["inputs"] = {"thrusters": {"axis": vehicle.get("axis", "yaw")}}
    return found
