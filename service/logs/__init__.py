"""Logs as vehicles write them: one value, one reader a format, chosen by what is in the file and not by its name."""

from __future__ import annotations

from service.inputs.table import Table, Topic
from service.logs.log import Log
from service.logs.opening import open_any

__all__ = ["Log", "Table", "Topic", "open_any"]
