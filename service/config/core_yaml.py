"""YAML as people write it, read by the core schema of YAML 1.2: the one loader of every YAML file and value.

In YAML 1.1, which most loaders follow, `0350` is 232, `yes` is true and of two equal names the last one counts. Here
`0350` is 350, `yes` is a text, and a name that is given twice is refused with both lines. Nesting, aliases and size are
bounded, so that no file takes longer than a second to refuse.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import yaml

from incsvr.errors import BadInput

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

    def wrong(self, where: Any, sentence: str) -> BadInput:
        return BadInput(f"{self._name}, line {where.start_mark.line + 1}: {sentence}")
