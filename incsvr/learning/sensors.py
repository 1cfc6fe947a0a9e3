"""The verdict of the checks on the sensors of whole recordings, for the tracer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from incsvr.checks import MODEL_KINDS, Finding, Vehicle, Verdict, verdict_sentences
from incsvr.learning import checked_learner
from incsvr.learning.iteration import Settings
from incsvr.signals.samples import Samples

IMPOSSIBLE_KINDS = frozenset({"yaw_rate stuck", "sign"})
"""Kinds of findings after which nothing that a recording says of the vehicle is right. A torque that stands still is
not among them: a moment that nobody declared may turn a vehicle whose torque is held."""
SIGN_KIND = "sign"
"""Kind of a sign that a Coriolis force or a Munk moment brings forth, too: they drive a vehicle without its thrust."""
STUCK_TORQUE_KIND = "torque stuck"
"""Kind of a stuck torque, likewise: they turn a vehicle on while a rudder keeps its angle."""
REVERSED_HEADING_KIND = "heading reversed"
"""Kind of a heading that counts the other way."""
MIN_REVERSED_SHARE = 0.5
"""The part of the batches that could tell, at least, of which a heading counts the other way: a compass is mounted for
good."""


@dataclass(frozen=True, slots=True)
class Sensors:
    """The verdict on the sensors of one recording."""

    remarks: tuple[str, ...]  # a sentence for each thing that a sensor or a clock does wrong
    # a sentence for each thing by which the motion differs from what was learned until then; it may be the vehicle's,
    # a sensor's, or what a tracer looks for
    of_the_model: tuple[str, ...]
    refusal: Finding | None  # after which nothing is to be concluded from the recording; None where something is
    heading_reversed: bool  # the heading counts in the other direction than the yaw rate


def examine(samples: Samples, settings: Settings, vehicle: Vehicle, coupled: bool = False) -> Sensors:
    """Follows the checks over the samples of one recording; what is learned on the way is forgotten.

    Args:
        coupled: whether velocities were recorded whose product may drive the vehicle.
    """
    verdicts = [verdict for verdict, _ in checked_learner.follow(settings, vehicle, samples, rest=True)]
    findings = [finding for verdict in verdicts for finding in verdict.findings]
    refused = IMPOSSIBLE_KINDS - {SIGN_KIND} if coupled else IMPOSSIBLE_KINDS
    of_the_model = MODEL_KINDS | {SIGN_KIND, STUCK_TORQUE_KIND} if coupled else MODEL_KINDS
    impossible = [finding for finding in findings if finding.kind in refused]
    turned = sum(any(finding.kind == REVERSED_HEADING_KIND for finding in verdict.findings) for verdict in verdicts)
    return Sensors(
        tuple(_only(verdicts, lambda finding: finding.kind not in of_the_model)),
        tuple(_only(verdicts, lambda finding: finding.kind in of_the_model)),
        impossible[0] if impossible else None,
        turned > MIN_REVERSED_SHARE * len(verdicts),
    )


def _only(verdicts: Sequence[Verdict], wanted: Callable[[Finding], bool]) -> list[str]:
    """The sentences of some findings; nothing is put aside."""
    return verdict_sentences(
        replace(verdict, findings=tuple(filter(wanted, verdict.findings)), learn=True) for verdict in verdicts
    )
