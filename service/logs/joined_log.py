"""Several logs of one dive as one: each topic's messages one after the other, the vehicle chosen over all of them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.inputs.owners import AUTOPILOT
from service.inputs.settings import Inputs
from service.inputs.table import Table, Topic
from service.inputs.vehicles import present_vehicles
from service.logs.choosing import choose_vehicle
from service.logs.log import Log


class JoinedLog:
    """The parts of a log in the order of time.

    A telemetry log calls the messages of the vehicle that it chose by their plain names. Over several of them the
    choice is made anew, so the plain names are those of the vehicle that is chosen over all parts.
    """

    def __init__(self, parts: Sequence[Log]) -> None:
        self.format = parts[0].format
        self._parts = parts
        self._system = ""
        self._places: dict[str, list[tuple[int, str]]] = {}
        topics: dict[str, Topic] = {}
        for k, part in enumerate(parts):
            for topic in part.topics:
                name = _in_full(topic)
                self._places.setdefault(name, []).append((k, topic.name))
                before = topics.get(name, Topic(name, topic.type, (), 0))
                fields = tuple(dict.fromkeys((*before.fields, *topic.fields)))
                topics[name] = replace(before, fields=fields, count=before.count + topic.count)
        self._topics = tuple(topics[name] for name in sorted(topics))
        if any(topic.system for part in parts for topic in part.topics):
            self._call_plainly(choose_vehicle(self).system)

    @property
    def topics(self) -> tuple[Topic, ...]:
        return self._topics

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes on messages of the parts that could not be read."""
        return tuple(dict.fromkeys(note for part in self._parts for note in part.notes))

    def read(self, names: Collection[str]) -> Mapping[str, Table]:
        wanted = [name for name in names if name in self._places]
        by_part: dict[int, list[str]] = {}
        for name in wanted:
            for k, own in self._places[name]:
                by_part.setdefault(k, []).append(own)
        tables = {k: self._parts[k].read(own) for k, own in by_part.items()}
        found = {name: [tables[k][own] for k, own in self._places[name] if own in tables[k]] for name in wanted}
        return {name: _join(parts) for name, parts in found.items() if parts}

    def _call_plainly(self, system: str) -> None:
        """The messages of this system's autopilot by their plain names."""
        plain = f"mavlink/{system}/{AUTOPILOT}/"
        self._places = {name.removeprefix(plain): places for name, places in self._places.items()}
        self._topics = tuple(
            replace(topic, name=topic.name.removeprefix(plain), system=system)
            if topic.name.startswith(plain)
            else topic
            for topic in self._topics
        )


def refuse_other_vehicles(paths: Sequence[Path], parts: Sequence[Log], joined: Log, inputs: Inputs) -> None:
    """Refuses parts that hold nothing of the vehicle that is taken.

    Raises:
        BadInput: naming the part and whose it is.
    """
    choice = choose_vehicle(joined, inputs)
    if not choice.others:
        return
    for path, part in zip(paths, parts, strict=True):
        here = present_vehicles(part.topics, choice.system)
        if choice.system not in here:
            raise BadInput(
                f"{path}: this part has no data of vehicle {choice.system}, which is used, but of vehicle "
                f"{', '.join(sorted(here))}: parts of one dive are of one vehicle; leave it out"
            )


def _in_full(topic: Topic) -> str:
    """The name of a topic that says whose it is."""
    return f"mavlink/{topic.system}/{AUTOPILOT}/{topic.name}" if topic.system else topic.name


def _join(parts: Sequence[Table]) -> Table:
    """The messages of several tables by their times of arrival."""
    if len(parts) == 1:
        return parts[0]
    counts = [part.count for part in parts]
    columns = {
        name: np.concatenate(
            [part.columns.get(name, np.full(n, np.nan)) for part, n in zip(parts, counts, strict=True)]
        )
        for name in dict.fromkeys(name for part in parts for name in part.columns)
    }
    texts = {
        name: tuple(text for part, n in zip(parts, counts, strict=True) for text in part.texts.get(name, ("",) * n))
        for name in dict.fromkeys(name for part in parts for name in part.texts)
    }
    came: list[Array] = [part.arrival for part in parts if part.arrival is not None]
    if len(came) < len(parts):
        return Table(None, columns, texts)
    arrival = np.concatenate(came)
    order = np.argsort(arrival, kind="stable")
    return Table(
        arrival[order],
        {name: values[order] for name, values in columns.items()},
        {name: tuple(values[k] for k in order) for name, values in texts.items()},
    )
