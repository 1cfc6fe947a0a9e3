"""Is what the sensors say to be believed? Checks on the two streams and the heading, the same live and from a file."""

from __future__ import annotations

from incsvr.signals.checks.agreement import YOUNG
from incsvr.signals.checks.curve import Curve, Served
from incsvr.signals.checks.judgement import check
from incsvr.signals.checks.misfit import OF_THE_MODEL
from incsvr.signals.checks.state import State, Vehicle
from incsvr.signals.checks.unit import implausible
from incsvr.signals.checks.verdict import Decision, Finding, Said, Verdict, told

__all__ = [
    "OF_THE_MODEL",
    "YOUNG",
    "Curve",
    "Decision",
    "Finding",
    "Said",
    "Served",
    "State",
    "Vehicle",
    "Verdict",
    "check",
    "implausible",
    "told",
]
