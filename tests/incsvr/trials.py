"""What the tracer names of a trial."""

from __future__ import annotations

from incsvr.tracing import trace
from incsvr.tracing.run import Run
from simulator.trial import Outcome


def as_run(outcome: Outcome) -> Run:
    """The recording as the tracer takes it."""
    columns = dict(outcome.recording.columns)
    return Run("trial", outcome.recording.time, columns.pop("yaw_rate"), columns.pop("torque"), columns)


def named(outcome: Outcome) -> set[str]:
    """What it names of a trial whose torque is measured."""
    found = trace([as_run(outcome)], inertia=outcome.inertia, torque="measured")
    return {finding.effect for finding in found.effects}
