"""The numbers and texts of a message of any form, by their paths."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

MAX_LIST_ITEMS = 64
"""Items of a list that are looked at: one with more is a picture or a point cloud, of which nothing is learned."""
MAX_DEPTH = 8
"""The depth to which nested messages are looked into."""


def leaves(message: Any, path: str = "", depth: int = 0) -> Iterator[tuple[str, float | str]]:
    """Numbers and texts of a message with their paths: `angular_velocity.z`, `data[3]`, `message.param_id`.

    A list of single characters is a text: so MAVLink's JSON writes names.
    """
    if isinstance(message, bool | int | float | np.number | np.bool_):
        yield path, float(message)
    elif isinstance(message, str):
        yield path, message
    elif isinstance(message, Mapping):
        if depth < MAX_DEPTH:
            for name, value in message.items():
                yield from leaves(value, f"{path}.{name}" if path else str(name), depth + 1)
    elif isinstance(message, Sequence | np.ndarray) and 0 < len(message) <= MAX_LIST_ITEMS:
        if all(isinstance(item, str) and len(item) <= 1 for item in message):
            yield path, "".join(message).rstrip("\0")
        elif not isinstance(message, bytes | bytearray):
            for index, item in enumerate(message):
                yield from leaves(item, f"{path}[{index}]", depth + 1)
