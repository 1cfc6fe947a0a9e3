"""Numbers of the trace that more than one of its functions need, each with its unit and its reason."""

from __future__ import annotations

OTHER_GYRO_CORRELATION = 0.12
"""Correlation at least where the log's gyro does not tell the torque beforehand (0.12 to 0.6 there; of 70 open loops
one reached it)."""
MIN_HEADING_SAMPLES = 5
"""Samples of a heading that is looked at."""
HORIZON_SCALES = (0.5, 1.0, 2.0, 5.0)
"""Time scales of the motion that the multi-step errors look ahead."""
TORQUE_BLOCK_SCALES = 0.25
"""Time scales in a block of the torque's error: within one the gyro's noise would be most of it."""
MAX_REJECTED = 12
"""Candidates that are listed as looked at and not added."""
