"""A learner that traces while a recording comes, as fast as it goes, and the same on every machine.

All is the learner's own but the process beside it: its work is done in its place, so that its answer comes before the
next batch and the machine's load changes nothing.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.config.configuration import Config
from service.learner.node import LearnerNode
from service.live.live_tracing import LiveTracing
from service.live.tracing_answer import answer
from service.live.tracing_state import TracingState
from service.recordings.recording import Recording
from service.wire.json_text import json_text

CHUNK_S = 3.0
"""So much of each stream comes at once [s]: less than a batch."""


@dataclass(frozen=True, slots=True)
class InPlace:
    """A piece of work that is done when its answer is asked for."""

    job: Mapping[str, Any]
    streams: Mapping[str, tuple[Array, Array]]

    @property
    def has_ended(self) -> bool:
        return True

    def answer(self) -> Any:
        return json.loads(json_text(answer(json.loads(json_text(self.job)), self.streams)))

    def close(self) -> None:
        pass


@dataclass(frozen=True, slots=True)
class Watched:
    """What came of it.

    Attributes:
        state: of live tracing at the end.
        history: every step of the ledger.
        residuals: (time [s], what was served leaves of the torque [N m]) of every sample before it was learned.
    """

    state: TracingState
    history: tuple[dict[str, Any], ...]
    residuals: tuple[Array, Array]


def watch(config: Config, recording: Recording) -> Watched:
    """Plays a recording to a learner of this configuration."""
    node = LearnerNode(config, boot="")
    live = LiveTracing(config, None, InPlace) if config.tracing.on else None
    history: list[dict[str, Any]] = []
    time, left = list[float](), list[float]()
    for start in np.arange(0.0, float(recording.time[-1]) + CHUNK_S, CHUNK_S).tolist():
        for name, (t, value) in recording.streams().items():
            here = (t >= start) & (t < start + CHUNK_S)
            if here.any():
                node.push(name, t[here], value[here])
        while (outcome := node.learn()) is not None:
            batch = outcome.report.batch
            if batch.predicted is not None:
                time += batch.time
                left += (np.array(batch.damping) - np.array(batch.predicted)).tolist()
        if live is not None:
            live.after(node)
            while live.waits:
                instead = live.conclude(node)
                if instead is not None:
                    try:
                        node.relearn(live.effects, {}, live.since)
                    except BadInput as error:
                        live.put_back(node, instead, str(error))
                live.after(node)
            history += [step for step in live.state.history if step not in history[-200:]]
    state = TracingState() if live is None else live.state
    return Watched(state, tuple(history), (np.array(time), np.array(left)))
