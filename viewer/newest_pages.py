"""One layout of the pages in a recording: the newest.

Each time the pages are laid out anew, the recording gets another blueprint beside those that it has, and the command
that makes it the active one. Rerun's `rrd optimize` writes blueprints in the order of their random names, and whichever
comes last is shown then: a page that came later would be lost in two recordings of three. So the older ones are left
out before.

A recording is a header of twelve bytes and messages: their kind and length, eight bytes each, and as much payload
(Rerun 0.41, `re_log_encoding`). A message names its store within its first bytes.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

HEADER, PREFIX = 12, struct.Struct("<QQ")
END, ACTIVATES = 0, 3
"""Kinds of message: the last one, and the command that makes a blueprint the active one."""
NAMED_WITHIN = 200
"""Bytes of a payload within which its store is named."""
_NAME = re.compile(rb"rec_[0-9a-f]{32}")


def superseded(parts: Sequence[Path]) -> frozenset[bytes]:
    """The names of all blueprints in these recordings, the newest last, but for the newest."""
    names = [
        name
        for part in parts
        for kind, payload in _messages(part)
        if kind == ACTIVATES
        for name in _NAME.findall(payload[:NAMED_WITHIN])
    ]
    return frozenset(names[:-1]) - frozenset(names[-1:])


def without(part: Path, names: frozenset[bytes], out: Path) -> None:
    """Copies a recording without these blueprints, and without its end: what reads it takes it for cut off."""
    with part.open("rb") as source, out.open("wb") as target:
        target.write(source.read(HEADER))
        for kind, payload in _of(source):
            found = _NAME.search(payload[:NAMED_WITHIN])
            if kind != END and (found is None or found[0] not in names):
                target.write(PREFIX.pack(kind, len(payload)))
                target.write(payload)


def _messages(part: Path) -> Iterator[tuple[int, bytes]]:
    with part.open("rb") as source:
        source.read(HEADER)
        yield from _of(source)


def _of(source: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Kind and payload of every whole message from here on."""
    while len(prefix := source.read(PREFIX.size)) == PREFIX.size:
        kind, length = PREFIX.unpack(prefix)
        payload = source.read(length)
        if len(payload) < length:
            return
        yield kind, payload
