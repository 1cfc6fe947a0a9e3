"""What the tracer says of one recording, as a record that can be judged."""

from __future__ import annotations

import time
from typing import Any

from benchmarks.study import Record
from incsvr.errors import BadInput
from incsvr.signals.settings import TorqueKind
from incsvr.tracing import trace
from service.commands.trace import runs_of
from service.recordings.recording import Recording


def answer(recording: Recording, inertia: float, torque: TorqueKind | None = None) -> Record:
    """What is named, or why nothing could be said: a refusal is an answer, and a crash is a result, too.

    Args:
        inertia: declared [kg m²].
        torque: what the torque is, where the tracer is told.
    """
    # Processor time: a busy machine must not make the tracer look slow.
    began = time.process_time()
    found, refused, failed = dict[str, Any](), None, None
    try:
        found = trace(runs_of([recording]), inertia=inertia, torque=torque).to_dict()
    except BadInput as refusal:
        refused = str(refusal)
    except Exception as error:  # the other recordings go on
        failed = f"{type(error).__name__}: {error}"
    seconds, effects = time.process_time() - began, found.get("effects", [])
    return {
        "refused": refused,
        "failed": failed,
        "verdict": found.get("verdict"),
        "loop": found.get("loop"),
        "proven": found.get("proven"),
        "named": {each["effect"]: list(each["cannot_tell_from"]) for each in effects},
        "parameters": {each["effect"]: each["parameters"] for each in effects},
        "p_values": {each["effect"]: each["p_value"] for each in effects},
        "error": found.get("error", {}),
        "seconds": seconds,
    }
