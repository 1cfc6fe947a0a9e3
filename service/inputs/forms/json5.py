"""JSON, and what JSON5 adds to it, as some versions of BlueOS's MAVLink server write it: names without quotes, single
quotes, commas before an end, numbers such as +.5, 0xFF and Infinity, comments."""

from __future__ import annotations

import json
import re
from typing import Any

from service.wire.json_text import RepeatedName, read_json

_TOKEN = re.compile(
    r"""(?P<double>"(?:[^"\\]|\\.)*")"""
    r"""|(?P<single>'(?:[^'\\]|\\.)*')"""
    r"""|(?P<comment>//[^\n]*|/\*.*?\*/)"""
    r"""|(?P<hex>[+-]?0[xX][0-9a-fA-F]+)"""
    r"""|(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"""
    r"""|(?P<name>[+-]?[A-Za-z_$][\w$]*)"""
    r"""|(?P<comma>,)"""
    r"""|(?P<mark>[{}\[\]:])"""
    r"""|(?P<space>\s+)""",
    re.DOTALL,
)
MAX_TEXT_BYTES = 65_536
"""The longest text that is read as JSON5: no message of MAVLink is a tenth as long, and this is read slowly."""
_VALUES = {"true", "false", "null", "NaN", "Infinity", "-Infinity"}


def read(payload: bytes) -> Any:
    """The value of a JSON or JSON5 text.

    Raises:
        ValueError: it is neither.
    """
    try:
        return read_json(payload)
    except RepeatedName:
        raise
    except ValueError:
        if len(payload) > MAX_TEXT_BYTES:
            raise
    return read_json(_as_json(payload.decode("utf-8")))


def _as_json(text: str) -> str:
    """JSON5 as JSON; what is neither is left to whoever reads it next."""
    found: list[str] = []
    place = 0
    while place < len(text):
        token = _TOKEN.match(text, place)
        if token is None:
            raise ValueError(f"it is no JSON at {place}")
        place = token.end()
        kind, said = token.lastgroup, token.group()
        if kind in ("comment", "space"):
            continue
        if kind == "mark" and said in "}]" and found[-1:] == [","] and found[-2:-1] not in (["{"], ["["]):
            found.pop()
        found.append(_as_json_token(str(kind), said))
    return " ".join(found)


def _as_json_token(kind: str, said: str) -> str:
    """A token as JSON spells it."""
    if kind == "single":
        return json.dumps(re.sub(r"\\(['\"])", r"\1", said[1:-1]))
    if kind == "hex":
        return str(int(said, 16))
    if kind == "number":
        return repr(float(said)) if any(each in said for each in ".eE") else str(int(said))
    if kind == "name":
        plain = said.removeprefix("+")
        return plain if plain in _VALUES else json.dumps(plain)
    return said
