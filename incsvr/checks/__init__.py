"""Is what the sensors say to be believed? Checks on the two streams and the heading, the same live and from a file."""

from __future__ import annotations

from incsvr.checks.agreement import MODEL_KINDS, YOUNG_CURVE_BATCHES
from incsvr.checks.curve import Curve, ServedCurve
from incsvr.checks.judgement import check
from incsvr.checks.state import State, Vehicle
from incsvr.checks.unit import implausible
from incsvr.checks.verdict import CurrentWarnings, Decision, Finding, Verdict, verdict_sentences

__all__ = [
    "MODEL_KINDS",
    "YOUNG_CURVE_BATCHES",
    "CurrentWarnings",
    "Curve",
    "Decision",
    "Finding",
    "ServedCurve",
    "State",
    "Vehicle",
    "Verdict",
    "check",
    "implausible",
    "verdict_sentences",
]
