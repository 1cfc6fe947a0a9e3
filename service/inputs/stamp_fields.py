"""The default paths of a message's stamp, in a log and on a bus alike."""

from __future__ import annotations

from collections.abc import Collection

from service.inputs.settings import StampUnit

HEADER_STAMP = "header.stamp"
"""The path at which the stamp of a message of ROS with a header is found [s]."""
_USUAL: tuple[tuple[str, StampUnit], ...] = (
    ("time_boot_ms", "ms"),
    ("message.time_boot_ms", "ms"),
    ("time_usec", "us"),
    ("message.time_usec", "us"),
    (HEADER_STAMP, "s"),
)
"""Path and unit of the stamps of MAVLink, in a telemetry log and in JSON, and of ROS."""


def usual_stamp(fields: Collection[str]) -> tuple[str, StampUnit]:
    """Path and unit of the stamp in messages with these fields; an empty path where the time of arrival counts."""
    return next((found for found in _USUAL if found[0] in fields), ("", "s"))
