"""Values put into a YAML text in their places: every other line, its comments and the order stay as they are."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import yaml

from incsvr.errors import BadInput
from service.config.core_yaml import parse
from service.wire.json_text import json_text

Place = tuple[str, ...]
"""The place of a value, as in `Document.lines`: ("learner", "gamma"), ("also", "0", "prefix")."""


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
            below = below[int(part)] if isinstance(below, list) else _section(below, part)
        below[place[-1]] = json.loads(json_text(value))
        if parse(text, name).value != wanted:
            raise BadInput(f"{name}: {'.'.join(place)} cannot be written there; write its section without an alias")
    return text


def _with_value(text: str, place: Place, value: Any) -> str:
    node = yaml.compose(text, Loader=yaml.SafeLoader)
    if node is None:
        return f"{text.rstrip()}\n{_block(place, value, '')}".lstrip()
    for depth, name in enumerate(place):
        if isinstance(node, yaml.SequenceNode):
            node = node.value[int(name)]
        elif isinstance(node, yaml.MappingNode):
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
