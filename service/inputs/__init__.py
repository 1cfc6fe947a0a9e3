"""The sources of measurements, on a bus or in a log: topics, fields, units, directions and clocks."""

from __future__ import annotations
