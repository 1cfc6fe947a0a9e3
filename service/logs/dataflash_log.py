"""ArduPilot's own logs (.BIN): messages that the log itself defines, stamped in µs since boot, read by pymavlink."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from incsvr.errors import BadInput
from service.logs.gathering import Gathering
from service.logs.packages import needed
from service.logs.table import Table, Topic

_SELF_DESCRIBING = {"FMT", "FMTU", "UNIT", "MULT"}
"""Messages about the log and not about the vehicle."""


class DataflashLog:
    """A DataFlash log; its messages are decoded where they are asked for."""

    def __init__(self, path: Path, reader: Any) -> None:
        self.format = "ArduPilot DataFlash"
        self._path, self._reader = path, reader
        self._formats = {
            each.name: each for each in reader.formats.values() if each.name not in _SELF_DESCRIBING and each.columns
        }
        self._counts = {each.name: reader.counts[key] for key, each in reader.formats.items()}

    @property
    def topics(self) -> tuple[Topic, ...]:
        return tuple(
            Topic(name, name, tuple(each.columns), self._counts[name])
            for name, each in sorted(self._formats.items())
            if self._counts[name]
        )

    def read(self, names: Collection[str]) -> Mapping[str, Table]:
        wanted = [name for name in names if self._counts.get(name) and name in self._formats]
        if not wanted:
            return {}
        gathered = {name: Gathering() for name in wanted}
        self._reader.rewind()
        while (message := self._reader.recv_match(type=wanted)) is not None:
            fields = {name: getattr(message, name) for name in message.get_fieldnames()}
            gathered[message.get_type()].add(_since_boot(fields), fields)
        return {name: messages.table() for name, messages in gathered.items()}


def open_log(path: Path) -> DataflashLog:
    """Reads the index of a log.

    Raises:
        BadInput: it is damaged from its beginning, or pymavlink is missing.
    """
    dataflash = needed("pymavlink.DFReader", path, "a DataFlash log")
    try:
        reader = dataflash.DFReader_binary(str(path), zero_time_base=True)
        reader.filehandle.close()  # what is read is mapped into memory
        return DataflashLog(path, reader)
    except (ValueError, IndexError, KeyError, OSError) as error:
        raise BadInput(f"{path}: cannot be read as a DataFlash log ({error}); download it again") from None


def _since_boot(fields: Mapping[str, Any]) -> float:
    if "TimeUS" in fields:
        return float(fields["TimeUS"]) * 1e-6
    return float(fields.get("TimeMS", 0)) * 1e-3
