"""ArduPilot's own logs (.BIN): messages that the log itself defines, stamped in µs since boot, indexed by pymavlink.

A message of several sensors says which of them it is of. Those of the first keep the name, `IMU`; those of others are
numbered, `IMU[1]`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.cli.extras import load_package
from service.inputs.table import Table, Topic
from service.logs.log import Damage

_LOG_MESSAGES = {"FMT", "FMTU", "UNIT", "MULT"}
"""Messages about the log and not about the vehicle."""
_HEADER_BYTES = 3
"""Bytes before the fields of a message: two that are always the same, and its number."""
_FORMATS = (
    {"b": "i1", "B": "u1", "M": "u1", "h": "<i2", "H": "<u2", "i": "<i4", "I": "<u4", "q": "<i8", "Q": "<u8"}
    | {"g": "<f2", "f": "<f4", "d": "<f8", "n": "S4", "N": "S16", "Z": "S64", "a": "V64"}
    | {"c": "<i2", "C": "<u2", "e": "<i4", "E": "<u4", "L": "<i4"}
)
"""NumPy's type by the letter of a field."""
_FACTORS = {"c": 1e-2, "C": 1e-2, "e": 1e-2, "E": 1e-2, "L": 1e-7}
"""The factors of integers by their letters."""
_INSTANCE_FIELDS = ("I", "Instance")
"""Fields that tell sensors apart in logs which do not say which field does."""


class DataflashLog:
    """A DataFlash log; its messages are decoded where they are asked for."""

    def __init__(self, path: Path, reader: Any) -> None:
        self.format = "ArduPilot DataFlash"
        self._damage = Damage(path)
        self._bytes = np.frombuffer(reader.data_map, dtype=np.uint8)
        self._messages: dict[str, tuple[Any, np.ndarray[Any, np.dtype[np.int64]]]] = {}
        whole = 0
        for number, form in reader.formats.items():
            places = np.asarray(reader.offsets[number], dtype=np.int64)
            places = places[places + form.len <= self._bytes.size]
            whole += form.len * places.size
            if places.size and form.columns and form.name not in _LOG_MESSAGES:
                for name, of_it in self._instances(form, places):
                    self._messages[name] = (form, of_it)
        self._damage.add_skipped(self._bytes.size - whole)

    @property
    def topics(self) -> tuple[Topic, ...]:
        return tuple(
            Topic(name, form.name, tuple(form.columns), places.size)
            for name, (form, places) in sorted(self._messages.items())
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes on messages that could not be read."""
        return self._damage.notes

    def read(self, names: Collection[str]) -> Mapping[str, Table]:
        return {name: self._table(*self._messages[name]) for name in names if name in self._messages}

    def _instances(self, form: Any, places: np.ndarray[Any, np.dtype[np.int64]]) -> list[tuple[str, Any]]:
        """The messages of each sensor, by the names of their topics."""
        field = form.instance_field or next((name for name in _INSTANCE_FIELDS if name in form.columns), None)
        fields = self._fields(form, places)
        if field is None or fields[field].dtype.kind not in "iu":
            return [(form.name, places)]
        sensor = fields[field]
        return [
            (form.name if k == 0 else f"{form.name}[{which}]", places[sensor == which])
            for k, which in enumerate(np.unique(sensor).tolist())
        ]

    def _fields(self, form: Any, places: np.ndarray[Any, np.dtype[np.int64]]) -> Any:
        """The messages as records, as they are stored."""
        kind = np.dtype([(name, _FORMATS[letter]) for name, letter in zip(form.columns, form.format, strict=False)])
        stored = self._bytes[places[:, None] + np.arange(_HEADER_BYTES, _HEADER_BYTES + kind.itemsize)]
        return np.ascontiguousarray(stored).view(kind)[:, 0]

    def _table(self, form: Any, places: np.ndarray[Any, np.dtype[np.int64]]) -> Table:
        fields = self._fields(form, places)
        columns: dict[str, Array] = {}
        texts: dict[str, tuple[str, ...]] = {}
        for name, letter in zip(form.columns, form.format, strict=False):
            if fields[name].dtype.kind == "S":
                texts[name] = tuple(each.decode("utf-8", "replace") for each in fields[name].tolist())
            elif fields[name].dtype.kind != "V":
                columns[name] = fields[name].astype(np.float64) * _FACTORS.get(letter, 1.0)
        return Table(_since_boot(columns, places.size), columns, texts)


def open_log(path: Path) -> DataflashLog:
    """Reads the index of a log.

    Raises:
        BadInput: it is damaged from its beginning, or pymavlink is missing.
    """
    dataflash = load_package("pymavlink.DFReader", path, "a DataFlash log")
    try:
        with redirect_stderr(StringIO()):  # a page that was not written in full is told there, byte by byte
            reader = dataflash.DFReader_binary(str(path), zero_time_base=True)
        reader.filehandle.close()  # what is read is mapped into memory
        log = DataflashLog(path, reader)
    except Exception as error:  # pymavlink raises whatever its parser stumbles over
        raise BadInput(f"{path}: cannot be read as a DataFlash log ({error}); download it again") from None
    if not log.topics:
        raise BadInput(f"{path}: there is no message in this DataFlash log; download it again")
    return log


def _since_boot(columns: Mapping[str, Array], count: int) -> Array:
    """The times of writing of the messages [s]."""
    if "TimeUS" in columns:
        return columns["TimeUS"] * 1e-6
    if "TimeMS" in columns:
        return columns["TimeMS"] * 1e-3
    return np.zeros(count)
