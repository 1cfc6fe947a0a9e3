"""Measurements in the forms of others, as `inputs` says: keys of a vehicle's bus become the learner's streams.

What is made of the messages follows from them and from their times of arrival, and not from when they are taken.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import zenoh

from incsvr.errors import BadInput
from service.bus.arrivals import Arrivals
from service.bus.feed import Arrived, Measurements
from service.bus.ingest import MAX_PAYLOAD_BYTES, MESSAGE_OVERHEAD_BYTES, QUEUE_BYTES, places
from service.config.configuration import Config
from service.health.health_watch import HealthWatch
from service.inputs.input_mapper import InputMapper
from service.inputs.settings import Axis, Inputs, Source
from service.inputs.source_binding import RATE, TORQUE
from service.recordings.archive import Archive
from service.wire import Keys

GRACE_S = 2.0
"""The time after which what has not come is said to be missing [s]: a heartbeat comes every second, streams more
often."""
PLACES_FACTOR = 4
"""The messages that may wait over those of our own form: each is read by itself, at 5,000 to 10,000 a second."""


class MappedIngest:
    """The subscriptions of one learner of so many in the process to the forms of others.

    Args:
        config: whose `inputs` is the mapping.
        parameters: of vehicles, as an earlier process heard them.
        further: axes of other learners of the vehicle, whose efforts the thrusters make as well.

    Raises:
        BadInput: a topic or a form of the configuration is none.
    """

    def __init__(
        self,
        session: zenoh.Session,
        watch: HealthWatch,
        config: Config,
        parameters: Mapping[str, Any],
        learners: int = 1,
        archive: Archive | None = None,
        further: tuple[Axis, ...] = (),
    ) -> None:
        self._watch = watch
        self.mapper = InputMapper(mapping(config), parameters, further)
        self._began, self._lock = time.monotonic(), threading.Lock()
        most_bytes = PLACES_FACTOR * max(QUEUE_BYTES // learners, MAX_PAYLOAD_BYTES + MESSAGE_OVERHEAD_BYTES)
        waiting = PLACES_FACTOR * places(learners)
        self._arrivals = Arrivals(session, self.mapper, watch.add_refusal, waiting, most_bytes, archive)

    def read(self) -> Arrived:
        """The measurements since the last call; they may be learned from while the vehicle is armed."""
        # Taken together, because the cost lies in the calls.
        came: dict[str, tuple[list[float], list[float]]] = {}
        learnable: dict[str, tuple[list[float], list[float]]] = {}
        refused = self.mapper.refused
        for key, payload, arrival in self._arrivals.take():
            with self._lock:
                mapped, may_learn = self.mapper.hear(key, payload, arrival), self.mapper.may_learn
            for values in mapped:
                if values.sequence is not None:
                    self._watch.add_number(values.name, values.sequence)
                for taken in (came, learnable) if may_learn else (came,):
                    t, value = taken.setdefault(values.name, ([], []))
                    t += values.t
                    value += values.value
        while refused:
            self._watch.add_refusal(*refused.popitem())
        # A sample is complete when both others have passed it, and takes what is there of the channels: they go first.
        ordered = sorted(learnable, key=lambda name: {TORQUE: 1, RATE: 2}.get(name, 0))
        return Arrived(_measurements(came), _measurements({name: learnable[name] for name in ordered}))

    @property
    def why_not(self) -> str | None:
        """The reason why measurements are not learned from; None if they are."""
        early = self.mapper.armed is None and time.monotonic() - self._began < GRACE_S
        return self.mapper.why_not if self.mapper.bindings and not early else None

    def notices(self) -> list[str]:
        """Notes for people on how the measurements are made, and what is missing."""
        late = time.monotonic() - self._began > GRACE_S
        with self._lock:
            return [*(self.mapper.missing.values() if late else ()), *self.mapper.notices()]

    def parameters(self) -> dict[str, dict[str, float]]:
        """The parameters that vehicles have sent, by vehicle."""
        with self._lock:
            return self.mapper.parameters_by_system

    def close(self) -> None:
        self._arrivals.close()


def _measurements(streams: Mapping[str, tuple[list[float], list[float]]]) -> list[Measurements]:
    """Stamps and values by stream, those of which there are any."""
    return [Measurements(name, np.array(t), np.array(value)) for name, (t, value) in streams.items() if t]


def mapping(config: Config) -> Inputs:
    """The inputs of a configuration: those that neither it nor its preset names have the learner's own keys.

    Raises:
        BadInput: a preset is to find another axis than yaw.
    """
    inputs, keys, axis = config.inputs, Keys(config.prefix), config.vehicle.axis
    if inputs.preset not in ("incsvr", None):
        if axis != "yaw" and (inputs.yaw_rate is None or (inputs.torque is None and inputs.thrusters is None)):
            raise BadInput(
                f"inputs.preset: {inputs.preset} proposes inputs for yaw alone; with vehicle.axis {axis} describe that "
                "velocity in inputs.yaw_rate, and its force in inputs.torque or inputs.thrusters"
            )
        return inputs
    own = {}
    if inputs.yaw_rate is None:
        own["yaw_rate"] = Source(topic=keys.rate, field="value", form="incsvr")
    if inputs.torque is None and inputs.thrusters is None:
        own["torque"] = Source(topic=keys.torque, field="value", form="incsvr")
    return inputs.model_copy(update=own)
