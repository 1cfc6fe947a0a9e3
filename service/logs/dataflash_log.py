"""ArduPilot's own logs (.BIN): messages that the log itself defines, stamped in µs since boot, indexed by pymavlink.

A message of several sensors says which of them it is of. Those of the first keep the name, `IMU`; those of others are
numbered, `IMU[1]`.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.cli.extras import load_package
from service.inputs.table import Table, Topic
from service.logs.log import Damage, Log

Bytes = np.ndarray[Any, np.dtype[np.uint8]]
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


def open_log(path: Path) -> Log:
    """Reads the whole file.

    Raises:
        BadInput: it is damaged from its beginning, or pymavlink is missing.
    """
    dataflash = load_package("pymavlink.DFReader", path, "a DataFlash log")
    try:
        with redirect_stderr(StringIO()):  # a page that was not written in full is told there, byte by byte
            reader = dataflash.DFReader_binary(str(path), zero_time_base=True)
        reader.filehandle.close()  # what is read is mapped into memory
        log = _log(path, reader)
    except Exception as error:  # pymavlink raises whatever its parser stumbles over
        raise BadInput(f"{path}: cannot be read as a DataFlash log ({error}); download it again") from None
    if not log.topics:
        raise BadInput(f"{path}: there is no message in this DataFlash log; download it again")
    return log


def _log(path: Path, reader: Any) -> Log:
    content = np.frombuffer(reader.data_map, dtype=np.uint8)
    damage, whole = Damage(path), 0
    topics, tables = list[Topic](), dict[str, Table]()
    for number, form in reader.formats.items():
        places = np.asarray(reader.offsets[number], dtype=np.int64)
        places = places[places + form.len <= content.size]
        whole += form.len * places.size
        if places.size and form.columns and form.name not in _LOG_MESSAGES:
            for name, records in _instances(form, _records(form, content, places)):
                topics.append(Topic(name, form.name, tuple(form.columns), records.size))
                tables[name] = _table(form, records)
    damage.add_skipped(content.size - whole)
    return Log("ArduPilot DataFlash", tuple(sorted(topics, key=lambda topic: topic.name)), tables, damage.notes)


def _records(form: Any, content: Bytes, places: np.ndarray[Any, np.dtype[np.int64]]) -> Any:
    """(n,) the messages as records, as they are stored at `places` (n,)."""
    kind = np.dtype([(name, _FORMATS[letter]) for name, letter in zip(form.columns, form.format, strict=False)])
    stored = content[places[:, None] + np.arange(_HEADER_BYTES, _HEADER_BYTES + kind.itemsize)]
    return np.ascontiguousarray(stored).view(kind)[:, 0]


def _instances(form: Any, records: Any) -> list[tuple[str, Any]]:
    """The messages of each sensor, by the names of their topics."""
    field = form.instance_field or next((name for name in _INSTANCE_FIELDS if name in form.columns), None)
    if field is None or records[field].dtype.kind not in "iu":
        return [(form.name, records)]
    sensor = records[field]
    return [
        (form.name if k == 0 else f"{form.name}[{which}]", records[sensor == which])
        for k, which in enumerate(np.unique(sensor).tolist())
    ]


def _table(form: Any, records: Any) -> Table:
    columns: dict[str, Array] = {}
    texts: dict[str, tuple[str, ...]] = {}
    for name, letter in zip(form.columns, form.format, strict=False):
        if records[name].dtype.kind == "S":
            texts[name] = tuple(each.decode("utf-8", "replace") for each in records[name].tolist())
        elif records[name].dtype.kind != "V":
            columns[name] = records[name].astype(np.float64) * _FACTORS.get(letter, 1.0)
    return Table(_since_boot(columns, records.size), columns, texts)


def _since_boot(columns: Mapping[str, Array], count: int) -> Array:
    """The times of writing of the messages [s]."""
    if "TimeUS" in columns:
        return columns["TimeUS"] * 1e-6
    if "TimeMS" in columns:
        return columns["TimeMS"] * 1e-3
    return np.zeros(count)
