"""YAML as people write it, read by the core schema of YAML 1.2: the one loader of every YAML file and value.

In YAML 1.1, which most loaders follow, `0350` is 232, `yes` is true and of two equal names the last one counts. Here
`0350` is 350, `yes` is a text, and a name that stands twice is refused with both lines. Nesting, aliases and size are
bounded, so that no file takes longer than a second to refuse.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import yaml

from incsvr.errors import BadInput

MAX_CHARACTERS = 1_000_000
"""A thousand learners of one process, each with a section of its own, take a fifth of it."""
MAX_DEPTH = 20
"""Levels of lists and sections: the configuration has eight."""
MAX_VALUES = 50_000
"""Values, each alias counted with all that it stands for: a thousand learners have some 30,000."""
MAX_QUOTED_CHARACTERS = 80
"""Characters of a name or a value that a sentence quotes: one line of a terminal."""
TEXT_CHARACTERS_A_VALUE = 100
"""A text counts as one value more for each of so many characters, so that aliases of a long one are bounded, too."""

_NULL = frozenset({"", "~", "null", "Null", "NULL"})
_BOOLEAN = {word: word.lower() == "true" for word in ("true", "True", "TRUE", "false", "False", "FALSE")}
_INTEGERS = (
    (re.compile(r"[-+]?[0-9]+"), 10),
    (re.compile(r"0o[0-7]+"), 8),
    (re.compile(r"0x[0-9a-fA-F]+"), 16),
)
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_INFINITE = re.compile(r"([-+]?)\.(inf|Inf|INF)")
_NOT_A_NUMBER = frozenset({".nan", ".NaN", ".NAN"})


class Document(NamedTuple):
    """The values of a YAML text, and the line of each by its place, such as ("learner", "gamma")."""

    value: Any
    lines: Mapping[tuple[str, ...], int]


def parse(text: str, name: str) -> Document:
    """The one document of a text; `name` is what a sentence calls it.

    Raises:
        BadInput: naming the line, and what is wrong there.
    """
    if len(text) > MAX_CHARACTERS:
        raise BadInput(f"{name}: this is no configuration: it is larger than {MAX_CHARACTERS // 1_000_000} MB")
    try:
        root = _Reader(yaml.parse(text, Loader=_LOADER), name).document()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = name if mark is None else f"{name}, line {mark.line + 1}"
        raise BadInput(f"{where}: this is no YAML: {error.problem or error.context}") from None
    except yaml.reader.ReaderError as error:
        count = 1 + text.count("\n", 0, error.position)
        raise BadInput(f"{name}, line {count}: this is no YAML: {error.reason}") from None
    return Document(root.value, dict(_lines(root, ())))


@dataclass(frozen=True, slots=True)
class _Node:
    """A value with its line, how many values and levels it has, and the nodes below by their names or numbers."""

    value: Any
    line: int
    size: int = 1
    height: int = 0
    below: Mapping[str, tuple[int, _Node]] = field(default_factory=dict)


class _Reader:
    """Puts the events of a parser together, one value after another."""

    def __init__(self, events: Iterator[Any], name: str) -> None:
        self._events, self._name = events, name
        self._anchors: dict[str, _Node] = {}
        self._left = MAX_VALUES

    def document(self) -> _Node:
        """The only document; an empty text holds null."""
        next(self._events)  # the stream begins
        if isinstance(next(self._events), yaml.StreamEndEvent):
            return _Node(None, 1)
        root = self._value(next(self._events), 0)
        next(self._events)  # the document ends
        after = next(self._events)
        if not isinstance(after, yaml.StreamEndEvent):
            raise self._wrong(after, "a second document begins here; keep one of them")
        return root

    def _value(self, event: Any, depth: int) -> _Node:
        found = self._alias(event) if isinstance(event, yaml.AliasEvent) else self._own(event, depth)
        if depth + found.height > MAX_DEPTH:
            raise self._wrong(event, f"lists and sections are nested more than {MAX_DEPTH} deep")
        return found

    def _alias(self, event: Any) -> _Node:
        found = self._anchors.get(event.anchor)
        if found is None:
            raise self._wrong(
                event, f"*{event.anchor} repeats nothing: mark a value that ends above it with &{event.anchor}"
            )
        self._spend(event, found.size)
        return found

    def _own(self, event: Any, depth: int) -> _Node:
        if event.tag is not None and event.tag != "!":
            raise self._wrong(event, f"the tag {event.tag} is not read; leave it out, and write a text in quotes")
        self._spend(event, 1)
        if depth > MAX_DEPTH:
            return _Node(None, _line(event))  # refused by who called, before anything below is read
        if isinstance(event, yaml.MappingStartEvent):
            found = self._mapping(event, depth)
        elif isinstance(event, yaml.SequenceStartEvent):
            found = self._sequence(event, depth)
        else:
            found = _Node(self._scalar(event), _line(event), 1 + len(event.value) // TEXT_CHARACTERS_A_VALUE)
        if event.anchor is not None:
            self._anchors[event.anchor] = found
        return found

    def _mapping(self, start: Any, depth: int) -> _Node:
        below: dict[str, tuple[int, _Node]] = {}
        while not isinstance(key := next(self._events), yaml.MappingEndEvent):
            if not isinstance(key, yaml.ScalarEvent):
                raise self._wrong(key, "a name is a text; write `name: value`")
            name, line = key.value, _line(key)
            if name == "<<" and key.implicit[0]:
                raise self._wrong(key, "sections are not merged by <<; write out what differs from the defaults")
            if name in below:
                raise self._wrong(key, f"{quote(name)} is given here and in line {below[name][0]}; keep one of them")
            below[name] = line, self._value(next(self._events), depth + 1)
        return _node({name: node.value for name, (_, node) in below.items()}, start, below)

    def _sequence(self, start: Any, depth: int) -> _Node:
        below: dict[str, tuple[int, _Node]] = {}
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            below[str(len(below))] = _line(event), self._value(event, depth + 1)
        return _node([node.value for _, node in below.values()], start, below)

    def _scalar(self, event: Any) -> Any:
        if not event.implicit[0]:  # in quotes
            return event.value
        try:
            return resolve(event.value)
        except ValueError:
            raise self._wrong(event, "this number has too many digits") from None

    def _spend(self, event: Any, count: int) -> None:
        self._left -= count
        if self._left < 0:
            raise self._wrong(event, f"the text has more than {MAX_VALUES} values up to here, with what aliases repeat")

    def _wrong(self, event: Any, sentence: str) -> BadInput:
        return BadInput(f"{self._name}, line {_line(event)}: {sentence}")


def resolve(text: str) -> Any:
    """The value of a plain scalar by the core schema of YAML 1.2.

    Raises:
        ValueError: it is a number of thousands of digits.
    """
    if text in _NULL:
        return None
    if text in _BOOLEAN:
        return _BOOLEAN[text]
    for pattern, base in _INTEGERS:
        if pattern.fullmatch(text):
            return int(text, base)
    if _FLOAT.fullmatch(text):
        return float(text)
    if infinite := _INFINITE.fullmatch(text):
        return float(f"{infinite[1]}inf")
    return float("nan") if text in _NOT_A_NUMBER else text


def quote(text: str) -> str:
    """A text of somebody as a sentence quotes it: on one line, cut where it is long."""
    line = "".join(each if each.isprintable() else "�" for each in text[:MAX_QUOTED_CHARACTERS])
    return line if len(text) <= MAX_QUOTED_CHARACTERS else f"{line}…"


def _node(value: Any, start: Any, below: Mapping[str, tuple[int, _Node]]) -> _Node:
    nodes = [node for _, node in below.values()]
    size, height = 1 + sum(node.size for node in nodes), 1 + max((node.height for node in nodes), default=0)
    return _Node(value, _line(start), size, height, below)


def _lines(node: _Node, place: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], int]]:
    for name, (line, below) in node.below.items():
        here = (*place, name)
        yield here, line
        yield from _lines(below, here)


def _line(event: Any) -> int:
    return int(event.start_mark.line) + 1


_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""The parser in C is ten times as fast; a wheel without it has the other one."""
