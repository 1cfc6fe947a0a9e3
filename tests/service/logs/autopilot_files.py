"""DataFlash, the file of ArduPilot, by its specification."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any


class Dataflash:
    """A DataFlash log by its specification: each message is 0xA3 0x95, its number and its packed fields."""

    def __init__(self) -> None:
        self._content = bytearray()
        self._numbers: dict[str, tuple[int, str]] = {}
        self._define("FMT", 128, "BBnNZ", "Type,Length,Name,Format,Columns")

    def _define(self, name: str, number: int, form: str, columns: str) -> None:
        self._numbers[name] = (number, form)
        length = 3 + struct.calcsize("<" + "".join(_STRUCT[each] for each in form))
        self.add("FMT", number, length, name.encode(), form.encode(), columns.encode())

    def define(self, name: str, form: str, columns: str) -> None:
        self._define(name, 130 + len(self._numbers), form, columns)

    def add(self, name: str, *values: Any) -> None:
        number, form = self._numbers[name]
        self._content += b"\xa3\x95" + bytes([number])
        self._content += struct.pack("<" + "".join(_STRUCT[each] for each in form), *values)

    def save(self, path: Path) -> Path:
        path.write_bytes(bytes(self._content))
        return path


_STRUCT: Mapping[str, str] = {"B": "B", "n": "4s", "N": "16s", "Z": "64s", "Q": "Q", "f": "f", "H": "H", "c": "h"}
