"""PX4's logs (.ulg), read by pyulog: topics stamped in µs since boot, of several instances each."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from service.cli.extras import load_package
from service.inputs.owners import numbered
from service.inputs.table import Table, Topic


class ULogLog:
    """A PX4 log. The first instance of a topic has its plain name, others are numbered: `sensor_gyro[1]`."""

    def __init__(self, log: Any) -> None:
        self.format = "PX4 ULog"
        damaged = "the file is damaged, as after a logger lost its power: its readable part is used"
        self.notes: tuple[str, ...] = (damaged,) if log.file_corruption else ()
        self._data = {numbered(each.name, each.multi_id): each for each in log.data_list}

    @property
    def topics(self) -> tuple[Topic, ...]:
        return tuple(
            Topic(name, each.name, tuple(each.data), each.data["timestamp"].size)
            for name, each in sorted(self._data.items())
        )

    def read(self, names: Collection[str]) -> Mapping[str, Table]:
        tables = {}
        for name in names:
            if name in self._data:
                data = {field: values.astype(np.float64) for field, values in self._data[name].data.items()}
                tables[name] = Table(data["timestamp"] * 1e-6, data, {})
        return tables


def open_log(path: Path) -> ULogLog:
    """Reads the whole file.

    Raises:
        BadInput: it is damaged from its beginning, or pyulog is missing.
    """
    pyulog = load_package("pyulog", path, "a PX4 log")
    try:
        return ULogLog(pyulog.ULog(str(path)))
    except Exception as error:  # pyulog raises whatever its parser stumbles over
        raise BadInput(f"{path}: cannot be read as a PX4 log ({error}); download it again") from None
