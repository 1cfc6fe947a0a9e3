"""The types that all rooms pass to each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
"""Numbers of double precision, of any shape."""
Stream: TypeAlias = tuple[Array, Array]
"""The stamps (n,) of a stream [s], strictly increasing, and its values (n,)."""
Streams: TypeAlias = Mapping[str, Stream]
"""Streams of a vehicle by name."""
