"""The generated lists of the reference: every command, every value of the configuration, every effect."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from incsvr.model.rows import Factor, row
from incsvr.plant.words import YAW_WORDS
from incsvr.tracing.effect_values import Here
from incsvr.tracing.vocabulary import WORDS, Word
from service.cli.command_line import whole_parser
from service.cli.parser import Parser
from service.config.config_writer import _bounds
from service.config.configuration import Config
from service.inputs.settings import Armed, Source, Thruster, Thrusters

MARK = "<!-- generated: python -m tests.docs.regenerate -->\n"
"""The line of a page below which everything is generated."""
ENTRIES_OF_INPUTS: dict[str, type[BaseModel]] = {
    "yaw_rate": Source,
    "thrusters": Thrusters,
    "thrusters.each": Thruster,
    "armed": Armed,
}
"""The forms of the entries of the section `inputs`; torque, channels and angles have the form of the yaw rate."""


def generated(page: str, text: str) -> str:
    """The text of a page with the list below its mark generated anew."""
    written_by_hand, mark, _ = text.partition(MARK)
    assert mark, page
    return f"{written_by_hand}{mark}\n{LISTS[page]()}\n"


def configuration() -> str:
    """The configuration's values, one list for each section."""
    top, sections = [], []
    for name, field in Config.model_fields.items():
        if isinstance(field.default, BaseModel):
            kind = type(field.default)
            sections.append(_section(kind, [name]))
        else:
            top.append(name)
    sections += [_section(kind, ["inputs", name]) for name, kind in ENTRIES_OF_INPUTS.items()]
    return f"## At the top\n\n{_values(Config, [], top)}\n\n" + "\n\n".join(sections)


def _section(kind: type[BaseModel], above: list[str]) -> str:
    shared = [name for name, field in kind.model_fields.items() if kind is not Source and _like_a_sources(name, field)]
    names = [name for name in kind.model_fields if name not in shared]
    as_there = f"\n- {', '.join(f'`{name}`' for name in shared)}: as of `inputs.yaw_rate`" if shared else ""
    return f"## {'.'.join(above)}\n\n{_first(kind)}\n\n{_values(kind, above, names)}{as_there}"


def _like_a_sources(name: str, field: FieldInfo) -> bool:
    """Whether the form of the yaw rate has the value, too, with the same default and the same words."""
    other = Source.model_fields.get(name)
    return other is not None and (other.description, other.default) == (field.description, field.default)


def _values(kind: type[BaseModel], above: list[str], names: list[str]) -> str:
    lines = []
    for name in names:
        field = kind.model_fields[name]
        default = ", needed" if field.default is PydanticUndefined else f" = `{_written(field.default)}`"
        what = f"{field.description or ''}{_short(_bounds(field.metadata))}".replace("<", "&lt;")
        lines.append(f"- `{'.'.join([*above, name])}`{default}: {what}")
    return "\n".join(lines)


def _short(bounds: str) -> str:
    """Bounds in signs: (above 0, at most 10) → (>0, ≤10)."""
    for words, sign in (("above ", ">"), ("below ", "<"), ("at least ", "≥"), ("at most ", "≤")):
        bounds = bounds.replace(words, sign)
    return bounds


def _written(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    return str(list(value)) if isinstance(value, tuple) else str(value) or '""'


def _first(kind: type[BaseModel]) -> str:
    return (kind.__doc__ or "").partition("\n")[0]


COMMON_FLAG_COMMANDS = 2
"""A flag that so many commands have in the same words is described once, in those that most of them have."""

GROUPS_OF_FLAGS = {
    "bus": ("--config", "--connect", "--prefix", "--set"),
    "log": ("--preset", "--column", "--system", "--from", "--to"),
}
"""Flags that go together, by the name that stands for them."""


def commands() -> str:
    """Every command with its flags, as its help has them; flags of several commands once, at the end."""
    found = whole_parser().commands
    rows = {parser: _rows(parser) for command in found.values() for parser in (command, *command.commands.values())}
    times = Counter(row for each in rows.values() for row in each)
    flags = {
        row: flag
        for each in rows.values()
        for row, flag in each.items()
        if flag.startswith("--") or flag == "RECORDING"
    }
    usual = {flag: row for row, flag in sorted(flags.items(), key=lambda each: times[each[0]])}
    common = {row: flag for row, flag in flags.items() if usual[flag] == row and times[row] >= COMMON_FLAG_COMMANDS}
    parts = []
    for name, command in found.items():
        about = f"## {name}\n\n{command.description} `{command.example}`"
        parts += [about, *_flags(rows[command], common)]
        for inner, below in command.commands.items():
            parts += [f"### {name} {inner}", *_flags(rows[below], common)]
    groups = "\n".join(f"- *{name}*: {_named(flags)}" for name, flags in GROUPS_OF_FLAGS.items())
    return "\n\n".join([*parts, "## Flags of several commands", groups, "\n".join(common)])


def _flags(rows: Mapping[str, str], common: Mapping[str, str]) -> Iterator[str]:
    """The list of a command's own flags, and the names of those that others have as well."""
    if own := [row for row in rows if row not in common]:
        yield "\n".join(own)
    if shared := [flag for row, flag in rows.items() if row in common]:
        groups = {name: flags for name, flags in GROUPS_OF_FLAGS.items() if set(flags) <= set(shared)}
        rest = [flag for flag in shared if not any(flag in flags for flags in groups.values())]
        also = " ".join([*(f"*{name}*" for name in groups), *([_named(rest)] if rest else [])])
        yield f"[Also](#flags-of-several-commands): {also}."


def _named(flags: Iterable[str]) -> str:
    return " ".join(f"`{flag}`" for flag in flags)


def _rows(parser: Parser) -> dict[str, str]:
    """Line of the list → name of the flag."""
    rows = {}
    for action in parser._actions:
        if isinstance(action, argparse._HelpAction | argparse._SubParsersAction):
            continue
        value = action.metavar or ("{" + ",".join(map(str, action.choices)) + "}" if action.choices else action.dest)
        values = " ".join(value) if isinstance(value, tuple) else value
        flags = ", ".join(action.option_strings)
        shown = flags if action.nargs == 0 else f"{flags} {values}".strip()
        text = (action.help or "") % {"default": action.default, "prog": parser.prog}
        rows[f"- `{shown}`{text and f': {text}'}"] = flags or values
    return rows


KINDS_OF_EFFECT = {
    "Thrusters": (
        "lag", "spin", "delay", "dead", "gap", "reverse", "limit", "sag", "thrust_step", "thrust_drift",
        "exponent", "thrust_speed", "modulation:thrust",
    ),
    "Inertia and damping": ("inertia", "drag_drift", "drag_step", "modulation"),
}  # fmt: skip
"""Heading → kinds of the engine's effects; all others are further moments."""
OF = {"cross_flow": "surge", "coriolis": "surge*sway"}
"""What stands in the name of an effect for any other velocity; else CHANNEL."""


def effects() -> str:
    """Every effect in yaw, by what it changes."""
    sorted_in = {kind for kinds in KINDS_OF_EFFECT.values() for kind in kinds}
    rest = tuple(kind for kind in WORDS if kind not in sorted_in and kind != "square")  # of other axes
    every = {**KINDS_OF_EFFECT, "Further moments": rest}
    return "\n\n".join(f"## {head}\n\n{_effects(kinds)}" for head, kinds in every.items())


def _effects(kinds: Iterable[str]) -> str:
    return "\n".join(_effect(kind, WORDS[kind]) for kind in kinds)


def _effect(kind: str, word: Word) -> str:
    parameters = ", ".join(f"`{name}`" for name in word.parameters(_Ones(), HERE))
    name = word.effect.format(of=OF.get(kind, "CHANNEL"))
    what = f"{_capital(word.sentence)}.<br>{word.equation}<br>{parameters}; needs {YAW_WORDS.fill(word.shown_by)}"
    return f"- `{name}`{f' (`shape: {word.shape}`)' if word.shape else ''}: {what}"


class _Ones(dict[str, Any]):
    """Parameters, or rows, of any name."""

    def __init__(self, value: Any = 1.0) -> None:
        super().__init__()
        self._value = value

    def __missing__(self, name: str) -> Any:
        return self._value


HERE = Here("yaw_rate", "", _Ones(row("", "yaw_rate", Factor("about", "", 1.0))), 1.0, 0.0, 1.0, 1.0, {}, 1.0, 0.0)
"""An axis of which the names of parameters are asked alone."""


def _capital(template: str) -> str:
    text = YAW_WORDS.fill(template)
    return text[0].upper() + text[1:]


LISTS = {"docs/commands.md": commands, "docs/configuration.md": configuration, "docs/effects.md": effects}
"""The pages with a generated list, and what generates it."""
