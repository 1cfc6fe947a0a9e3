"""Logs as vehicles write them: one protocol, one file a format, chosen by what is in the file and not by its name."""

from __future__ import annotations

from service.logs.opening import opened
from service.logs.table import Log, Table, Topic

__all__ = ["Log", "Table", "Topic", "opened"]
