"""What is measured, and where it stands: on a bus or in a log, in whichever unit, direction and clock."""

from __future__ import annotations
