"""Refusals in the words of Python: what a command calls a flag is a keyword there."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from contextlib import contextmanager

from incsvr.errors import BadInput
from service.cli.progress import without_bars

_WORD = r"""'[^']*'|"[^"]*"|[^\s,;()`]+"""
_COMMAND = re.compile(r"(`incsvr [^`]*`)")
_OF_ARRAYS = re.compile(r"[;,]? \(?`incsvr inspect (?:log|validate|dives)(?:\[\d+\])?` [a-z ]+\)?")
_COLUMNS = re.compile(rf"--column (?:{_WORD})(?: --column (?:{_WORD}))*")
_SET = re.compile(rf"--set ({_WORD})")
_VALUE = re.compile(r"--(inertia|config|vehicle|from|to) (I|estimate|FILE|T|[-+]?[\d.]+(?:e[-+]?\d+)?)(?![\w.])")
_FLAG = re.compile(r"--([a-z]+(?:-[a-z]+)*)")
_NAMES = {"from": "cut_from", "to": "cut_to", "assume-sign": "assume_sign=True"}


@contextmanager
def in_python() -> Iterator[None]:
    """A context without progress bars, whose refusals speak of keywords.

    Raises:
        BadInput: whatever refuses.
    """
    try:
        with without_bars():
            yield
    except BadInput as error:
        raise BadInput(with_keywords(str(error))) from error


def with_keywords(sentence: str) -> str:
    """A sentence with keywords in place of flags; commands in it stay as they are.

    >>> with_keywords("give --column 'yaw_rate=r z' --column t=t:ms, or --inertia estimate (`incsvr fit --force`)")
    'give column=["yaw_rate=r z", "t=t:ms"], or inertia="estimate" (`incsvr fit --force`)'
    >>> with_keywords("give --set signals.smoothing=0.2; --assume-sign uses both as recorded")
    'give set={"signals.smoothing": 0.2}; assume_sign=True uses both as recorded'
    """
    parts = _COMMAND.split(_OF_ARRAYS.sub("", sentence))
    return "".join(part if _COMMAND.fullmatch(part) else _keywords(part) for part in parts)


def _keywords(part: str) -> str:
    part = _COLUMNS.sub(_columns, part)
    part = _SET.sub(_set, part)
    part = _VALUE.sub(lambda found: f"{_name(found[1])}={_value(found[2])}", part)
    part = _FLAG.sub(lambda found: _name(found[1]), part)
    return part.replace("a config=FILE", "config=FILE").replace("this command", "this function")


def _name(flag: str) -> str:
    return _NAMES.get(flag, flag.replace("-", "_"))


def _columns(found: re.Match[str]) -> str:
    words = [_unquoted(word) for word in re.findall(rf"--column ({_WORD})", found[0])]
    texts = [f'"{word.removesuffix(":")}"' for word in words]
    every = ", ".join(texts)
    return (f"column={every}" if len(texts) == 1 else f"column=[{every}]") + ":" * words[-1].endswith(":")


def _set(found: re.Match[str]) -> str:
    word = _unquoted(found[1])
    end = ":" * word.endswith(":")
    name, equals, value = word.removesuffix(":").partition("=")
    return (f'set={{"{name}": {_value(value)}}}' if equals else f'set["{name}"]') + end


def _unquoted(word: str) -> str:
    return " ".join(shlex.split(word)) if word[0] in "'\"" else word


def _value(text: str) -> str:
    """A number or a list as it is, a placeholder too, and a text in quotes."""
    plain = text in ("I", "FILE", "T", "…") or text[:1] in "[{" or re.fullmatch(r"[-+]?[\d.]+(e[-+]?\d+)?", text)
    return text if plain else f'"{text}"'
