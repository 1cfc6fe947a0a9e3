"""A whole vehicle: all axes identified together from recordings, judged on unseen ones, and compared over dives."""

from __future__ import annotations

from incsvr.vehicle.compare import Comparison, compare
from incsvr.vehicle.identify import Identified, identify
from incsvr.vehicle.model import Parameter, Vehicle

__all__ = ["Comparison", "Identified", "Parameter", "Vehicle", "compare", "identify"]
