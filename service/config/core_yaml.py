"""YAML as people write it, read by the core schema of YAML 1.2: loader and editor of all YAML.

In YAML 1.1, which most loaders follow, `0350` is 232, `yes` is true and of two equal names the last one counts. Here
`0350` is 350, `yes` is a text, and a name that is given twice is refused with both lines. Nesting, aliases and size are
bounded, so that no file takes longer than a second to refuse.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import yaml

from incsvr.errors import BadInput
from service.wire.json_text import json_text

MAX_CHARACTERS = 1_000_000  # a thousand learners of one process, each with a section of its own, take a fifth of it
MAX_DEPTH = 20  # levels of lists and sections: the configuration has eight
MAX_VALUES = 50_000  # each alias counted with all that it repeats: a thousand learners have some 30,000
TEXT_CHARACTERS_A_VALUE = 100  # a long text counts as several values, so that aliases of it are bounded, too
MAX_QUOTED_CHARACTERS = 80  # of a name or a value that a sentence quotes: one line of a terminal

_WORDS: Mapping[str, Any] = dict.fromkeys(("", "~", "null", "Null", "NULL")) | {
    word: word.lower() == "true" for word in ("true", "True", "TRUE", "false", "False", "FALSE")
}
_NUMBERS = (
    (re.compile(r"[-+]?[0-9]+"), int),
    (re.compile(r"0o[0-7]+"), lambda text: int(text, 8)),
    (re.compile(r"0x[0-9a-fA-F]+"), lambda text: int(text, 16)),
    (re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?"), float),
    (re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)"), lambda text: float(text.replace(".", ""))),
)
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # in C it is ten times as fast; a wheel may lack it


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
    reader, depth = _Reader(name), 0
    try:
        for event in yaml.parse(text, Loader=_LOADER):
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if depth > MAX_DEPTH:
                raise reader.wrong(event, f"lists and sections are nested more than {MAX_DEPTH} deep")
            if (tag := getattr(event, "tag", None)) is not None:
                raise reader.wrong(event, f"the tag {tag} is not read; leave it out, and write a text in quotes")
        root = yaml.compose(text, Loader=_LOADER)
        return Document(None if root is None else reader.value(root, ()), reader.lines)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = name if mark is None else f"{name}, line {mark.line + 1}"
        raise BadInput(f"{where}: this is no YAML: {' '.join(filter(None, (error.context, error.problem)))}") from None
    except yaml.reader.ReaderError as error:
        count = 1 + text.count("\n", 0, error.position)
        raise BadInput(f"{name}, line {count}: this is no YAML: {error.reason}") from None


def quote(text: str) -> str:
    """A text of somebody as a sentence quotes it: on one line, cut where it is long."""
    line = "".join(each if each.isprintable() else "�" for each in text[:MAX_QUOTED_CHARACTERS])
    return line if len(text) <= MAX_QUOTED_CHARACTERS else f"{line}…"


class _Reader:
    """Makes values of nodes, and keeps their lines."""

    def __init__(self, name: str) -> None:
        self._name, self._left = name, MAX_VALUES
        self.lines: dict[tuple[str, ...], int] = {}

    def value(self, node: yaml.Node, place: tuple[str, ...]) -> Any:
        self._left -= 1 + (len(node.value) // TEXT_CHARACTERS_A_VALUE if isinstance(node, yaml.ScalarNode) else 0)
        if self._left < 0:
            raise self.wrong(node, f"the text has more than {MAX_VALUES} values up to here, with what aliases repeat")
        if len(place) > MAX_DEPTH:  # by what an alias repeats
            raise self.wrong(node, f"lists and sections are nested more than {MAX_DEPTH} deep")
        if isinstance(node, yaml.SequenceNode):
            return [self._below(each, each, (*place, str(k))) for k, each in enumerate(node.value)]
        if isinstance(node, yaml.ScalarNode):
            return node.value if node.style else self._plain(node)
        found: dict[str, Any] = {}
        for key, below in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise self.wrong(key, "a name is a text; write `name: value`")
            here = (*place, key.value)
            if key.value in found:
                raise self.wrong(
                    key, f"{quote(key.value)} is given here and in line {self.lines[here]}; keep one of them"
                )
            found[key.value] = self._below(key, below, here)
        return found

    def _below(self, key: yaml.Node, node: yaml.Node, place: tuple[str, ...]) -> Any:
        self.lines[place] = key.start_mark.line + 1
        return self.value(node, place)

    def _plain(self, node: yaml.ScalarNode) -> Any:
        """The value of a text without quotes, by the core schema."""
        if node.value in _WORDS:
            return _WORDS[node.value]
        of = next((number for form, number in _NUMBERS if form.fullmatch(node.value)), str)
        try:
            return of(node.value)
        except ValueError:
            raise self.wrong(node, "this number has too many digits") from None

    def wrong(self, where: yaml.Node | yaml.Event, sentence: str) -> BadInput:
        line = 1 if where.start_mark is None else where.start_mark.line + 1
        return BadInput(f"{self._name}, line {line}: {sentence}")


Place = tuple[str, ...]
"""The place of a value, as in `Document.lines`: ("learner", "gamma"), ("learners", "rov", "prefix")."""


def with_values(text: str, values: Mapping[Place, Any], name: str) -> str:
    """The text with these values; `name` is what a sentence calls it.

    Raises:
        BadInput: a value has no place in the text: it is repeated by an alias, or what is there is no section.
    """
    wanted = json.loads(json_text(parse(text, name).value or {}))  # without what aliases share
    for place, value in values.items():
        text = _with_value(text, place, value)
        below = wanted
        for part in place[:-1]:
            below = _section(below, part)
        below[place[-1]] = json.loads(json_text(value))
        if parse(text, name).value != wanted:
            raise BadInput(f"{name}: {'.'.join(place)} cannot be written there; write its section without an alias")
    return text


def _with_value(text: str, place: Place, value: Any) -> str:
    node = yaml.compose(text, Loader=yaml.SafeLoader)
    if node is None:
        return f"{text.rstrip()}\n{_block(place, value, '')}".lstrip()
    for depth, name in enumerate(place):
        if isinstance(node, yaml.MappingNode):
            below = next((each for key, each in node.value if key.value == name), None)
            if below is None:
                return _with_line(text, node, place[depth:], value)
            node = below
        else:  # an empty section
            return _replaced(text, node, _flow(place[depth:], value))
    return _replaced(text, node, json_text(value))


def _with_line(text: str, section: yaml.MappingNode, place: Place, value: Any) -> str:
    """The text with one value more in a section that has others, or is written as {}."""
    if section.flow_style:
        end = section.end_mark.index - 1
        before = text[:end].rstrip()
        inner = _flow(place, value)[1:-1]
        return f"{before}{', ' if section.value else ''}{inner}{text[end:]}"
    line_end = text.find("\n", max(_end(section) - 1, 0))
    end = len(text) if line_end < 0 else line_end
    return f"{text[:end]}\n{_block(place, value, ' ' * section.start_mark.column)}{text[end:]}"


def _replaced(text: str, node: yaml.Node, written: str) -> str:
    first, last = node.start_mark.index, _end(node)
    space = " " if first == last else ""  # nothing stands there yet
    return f"{text[:first]}{space}{written}{text[last:]}"


def _end(node: yaml.Node) -> int:
    """Where a value ends; what the parser calls the end of a block is behind the comments that follow it."""
    while isinstance(node, yaml.CollectionNode) and not node.flow_style:
        node = node.value[-1][1] if isinstance(node, yaml.MappingNode) else node.value[-1]
    return int(node.end_mark.index)


def _block(place: Place, value: Any, indent: str) -> str:
    lines = [f"{indent}{'  ' * depth}{name}:" for depth, name in enumerate(place)]
    return "\n".join(lines) + f" {json_text(value)}"


def _flow(place: Place, value: Any) -> str:
    return "".join(f"{{{name}: " for name in place) + json_text(value) + "}" * len(place)


def _section(of: dict[str, Any], name: str) -> Any:
    """The section of this name, made where it is missing or empty."""
    if of.get(name) is None:
        of[name] = {}
    return of[name]
