"""The threads of the learner's process: few, however many learners it holds, for threads that wait for each other cost.

One takes measurements in, one trains, one answers for models and health, one watches over health; damping and
feed-forward are answered by threads of each learner. A measurement waits READ_PERIOD_S at most, which is nothing to a
batch of samples; a question does not wait.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from types import TracebackType
from typing import Self

from incsvr.plant.axes import AXES, stream_of
from incsvr.signals import TORQUE, YAW_RATE
from service.host.host import Host


def share_streams(hosts: Sequence[Host]) -> None:
    """Connects learners: each receives streams that others get for it, and health names vehicles of several axes."""
    for host in hosts:
        _name_vehicle(host, hosts)
    for host in first_of_each_axis(hosts):
        _send_velocity(host, hosts)
    for other in hosts:
        first = next(host for host in hosts if _vehicle(host) == _vehicle(other))
        if first.node.config.hears(other.node.config) and other.mapped is None:
            _lead(first, other, hosts)


def first_of_each_axis(hosts: Sequence[Host]) -> list[Host]:
    """The first of several learners of the same axis of a vehicle: all receive the same."""
    found: dict[tuple[str, str], Host] = {}
    for host in hosts:
        vehicle = host.node.config.vehicle
        found.setdefault((vehicle.name, vehicle.axis), host)
    return list(found.values())


def _vehicle(host: Host) -> str:
    return host.node.config.vehicle.name


def _name_vehicle(host: Host, hosts: Sequence[Host]) -> None:
    """Health names the vehicle where learners of several of its axes are in this process."""
    vehicle = host.node.config.vehicle.name
    axes: dict[str, str] = {}
    for other in hosts:
        if other.node.config.vehicle.name == vehicle:
            axes.setdefault(other.node.config.vehicle.axis, other.keys.prefix)
    if len(axes) > 1:
        host.watch.belongs_to(vehicle, axes)


def _send_velocity(host: Host, hosts: Sequence[Host]) -> None:
    """The velocity that a learner hears goes to those of the same vehicle whose samples wait for it."""
    for other in hosts:
        for name in other.node.config.hears(host.node.config):
            if name in other.node.config.signal_settings().channels:
                _send(host, YAW_RATE, other, name)


def _lead(first: Host, other: Host, hosts: Sequence[Host]) -> None:
    """What comes to the first learner of a vehicle goes to another one: channels that it waits for, and what a
    mapping makes of the messages of others, so that each message is read once."""
    other.led_by = first.mapped
    mapped = {*first.node.config.inputs.channels, *(AXES[name].effort for name in first.further)}
    told = {name for each in hosts for name in other.node.config.hears(each.node.config)}
    for name in other.node.config.signal_settings().channels:
        if name not in told or name in mapped:
            _send(first, name, other, name)
    axis = AXES[other.node.config.vehicle.axis]
    for name, own in ((stream_of(AXES[first.node.config.vehicle.axis], axis.rate), YAW_RATE), (axis.effort, TORQUE)):
        if name in mapped:
            _send(first, name, other, own)
    if axis.effort in mapped:
        first.feed.elsewhere.add(axis.effort)


def _send(host: Host, stream: str, other: Host, name: str) -> None:
    """A stream goes to another learner, under this name."""
    host.feed.watched[stream].append(partial(other.watch.add_values, name))
    host.feed.onward[stream].append(partial(other.node.push, name))


log = logging.getLogger(__name__)

READ_PERIOD_S = 0.25
"""The time after which measurements are read again [s]: the cost lies in the calls, whatever they bring."""
LOOK_PERIOD_S = 0.05
"""The time after which it is looked at whether so many wait that they are read earlier [s]."""
MANY_WAITING = 0.5
"""Part of a ring from which on they are."""
HEALTH_CHECK_PERIOD_S = 0.5
"""The time after which health is looked at again [s]."""


class WorkerThreads:
    """Works for learners from `with` to its end; then they have said goodbye, saved and closed.

    Args:
        hosts: the learners; each tells the velocity of its axis to those of the same vehicle that wait for it.
        stroke: called by the thread that learns, for a watchdog that is to miss it where that thread hangs.
        period: how often at least it is called [s]; None where no watchdog watches.
    """

    def __init__(
        self, hosts: Sequence[Host], stroke: Callable[[], None] = lambda: None, period: float | None = None
    ) -> None:
        self._hosts, self._stroke, self._period = hosts, stroke, period
        share_streams(hosts)
        self._stop, self._batch, self._asked = threading.Event(), threading.Event(), threading.Event()
        for host in hosts:
            host.answers.when_asked(self._asked.set)
        self._threads = [
            threading.Thread(target=work, name=work.__name__.strip("_"), daemon=True)
            for work in (self._take_in, self._train, self._answer, self._watch)
        ]

    def __enter__(self) -> Self:
        self._batch.set()  # one may have been waiting when the process before ended
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._each(Host.goodbye, self._hosts)
        self._stop.set()
        self._batch.set()
        self._asked.set()
        for thread in self._threads:
            thread.join()
        self._each(lambda host: host.feed.hear(), self._hosts)
        self._each(Host.close, self._hosts)

    def _take_in(self) -> None:
        waiting: dict[Host, float] = {}

        def look(host: Host) -> None:
            waiting[host] = host.feed.waiting()

        def hear(host: Host) -> None:
            if host.feed.hear():
                self._batch.set()

        def learn(host: Host) -> None:
            if host.feed.learn():
                self._batch.set()

        due = time.monotonic() + READ_PERIOD_S
        while not self._stop.wait(LOOK_PERIOD_S):
            waiting.clear()
            self._each(look, self._hosts)
            if time.monotonic() < due and max(waiting.values(), default=0.0) < MANY_WAITING:
                continue
            due = time.monotonic() + READ_PERIOD_S
            visited = [host for host, part in waiting.items() if part]
            # What one hears may be another's, too: each is told all of it before its samples are made.
            self._each(hear, visited)
            self._each(learn, visited)

    def _train(self) -> None:
        while not self._stop.is_set():
            self._batch.wait(self._period)
            self._batch.clear()
            waiting = list(self._hosts)
            while waiting and not self._stop.is_set():
                waiting = [host for host in waiting if self._learn_one(host)]

    def _learn_one(self, host: Host) -> bool:
        """One iteration, where a batch waits; what fails for one learner does not end the learning of the others."""
        if self._period is not None:
            self._stroke()
        try:
            return host.learn()
        except Exception as error:
            log.exception("%s: a fault of this program", host.keys.prefix)
            host.watch.add_failure(f"what was learned could not be published: {error}")
            return False

    def _answer(self) -> None:
        def answer(host: Host) -> None:
            if host.answers.answer():
                self._batch.set()

        while not self._stop.is_set():
            self._asked.wait()
            self._asked.clear()
            self._each(answer, self._hosts)

    def _watch(self) -> None:
        def tick(host: Host) -> None:
            if host.tick():
                self._batch.set()

        while not self._stop.wait(HEALTH_CHECK_PERIOD_S):
            self._each(tick, self._hosts)

    def _each(self, work: Callable[[Host], object], hosts: Sequence[Host]) -> None:
        """Does it for these learners; what fails for one is said and does not end the work for the others."""
        for host in hosts:
            try:
                work(host)
            except Exception:
                log.exception("%s: a fault of this program", host.keys.prefix)
