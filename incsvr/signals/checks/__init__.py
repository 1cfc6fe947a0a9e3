"""Is what the sensors say to be believed? Checks on the two streams and the heading, the same live and from a file."""

from __future__ import annotations

from incsvr.signals.checks.curve import Curve
from incsvr.signals.checks.judgement import YOUNG, State, Vehicle, check
from incsvr.signals.checks.unit import implausible
from incsvr.signals.checks.verdict import Decision, Finding, Said, Verdict, told

__all__ = [
    "YOUNG",
    "Curve",
    "Decision",
    "Finding",
    "Said",
    "State",
    "Vehicle",
    "Verdict",
    "check",
    "implausible",
    "told",
]
