"""Health as ROS 2 knows it: `diagnostic_msgs/msg/DiagnosticArray` in CDR, for its own tools and dashboards.

On the bus of rmw_zenoh a message comes with an attachment, or nobody takes it, and with liveliness tokens by which it
is found (rmw_zenoh, docs/design.md). A bridge to DDS needs neither: its key is the topic.
"""

from __future__ import annotations

import hashlib
import time
from typing import Any

import zenoh
from zenoh.ext import Int64, z_serialize

from service.inputs.forms import cdr
from service.inputs.owners import ros_type
from service.wire import Health

DIAGNOSTIC_TYPE = "diagnostic_msgs/msg/DiagnosticArray"
RMW_TYPE = "diagnostic_msgs::msg::dds_::DiagnosticArray_"
TYPE_HASH = "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"
"""The hash that REP-2011 makes of the definition of the type."""
TOPIC = "diagnostics"
"""The topic at which ROS 2 has its diagnostics (REP-107)."""
LEVEL_BYTES = {"OK": 0, "WARN": 1, "ERROR": 2, "STALE": 3}
NODE_NUMBER, ENTITY_NUMBER = 0, 1
"""Numbers of the node and of its publisher in the tokens of a session, which is no other's."""


def diagnostics_key(rate_key: str) -> str:
    """The key of the diagnostics on the bus of ROS 2 on which the yaw rate has this key."""
    if ros_type(rate_key) is None:
        return TOPIC
    return f"{rate_key.partition('/')[0]}/{TOPIC}/{RMW_TYPE}/{TYPE_HASH}"


def diagnostic_array(health: Health, prefix: str, vehicle: str, at: int) -> bytes:
    """Health as a DiagnosticArray of one status; `at` is its stamp [ns since 1970]."""
    learning = health.learning
    said = {
        "learning": learning.state,
        "why": learning.why,
        "learned": f"{health.learned:.3f}",
        "revision": str(health.revision),
        "iteration": str(health.iteration),
        **{name: str(count) for name, count in health.counters.items()},
        **{f"reason {number}": reason for number, reason in enumerate(health.reasons[1:], start=2)},
    }
    status = {
        "level": LEVEL_BYTES[health.level],
        "name": f"incsvr: {prefix}",
        "message": health.reasons[0] if health.reasons else learning.state,
        "hardware_id": vehicle,
        "values": [{"key": name, "value": value} for name, value in said.items() if value],
    }
    return cdr.encode(DIAGNOSTIC_TYPE, {"header": {"stamp": at, "frame_id": ""}, "status": [status]})


class Diagnostics:
    """Publishes health on a key of ROS 2."""

    def __init__(self, session: zenoh.Session, key: str, prefix: str, vehicle: str) -> None:
        self._prefix, self._vehicle, self._sequence = prefix, vehicle, 0
        self._publisher = session.declare_publisher(key)
        self._gid, self._tokens = b"", list[Any]()
        if ros_type(key) == DIAGNOSTIC_TYPE:
            tokens = _tokens(str(session.info.zid()), key, prefix)
            self._gid = hashlib.md5(tokens[-1].encode(), usedforsecurity=False).digest()
            self._tokens = [session.liveliness().declare_token(token) for token in tokens]

    def tell(self, health: Health) -> None:
        at = time.time_ns()
        self._sequence += 1
        attachment = z_serialize((Int64(self._sequence), Int64(at), self._gid)) if self._gid else None
        self._publisher.put(diagnostic_array(health, self._prefix, self._vehicle, at), attachment=attachment)

    def close(self) -> None:
        for token in self._tokens:
            token.undeclare()


def _tokens(session: str, key: str, prefix: str) -> tuple[str, str]:
    """The liveliness tokens of a node and of its publisher, whose settings are those that are usual."""
    domain, *topic, kind, hashed = key.split("/")
    node = f"@ros2_lv/{domain}/{session}/{NODE_NUMBER}"
    name = "incsvr_" + "".join(letter if letter.isalnum() else "_" for letter in prefix)
    place = "".join(f"%{part}" for part in topic)
    return (
        f"{node}/{NODE_NUMBER}/NN/%/%/{name}",
        f"{node}/{ENTITY_NUMBER}/MP/%/%/{name}/{place}/{kind}/{hashed}/::,10:,:,:,,",
    )
