"""PX4's logs (.ulg), read by pyulog: topics stamped in µs since boot, of several instances each."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from service.cli.extras import load_package
from service.inputs.owners import numbered
from service.inputs.table import Table, Topic
from service.logs.log import Log


def open_log(path: Path) -> Log:
    """Reads the whole file. The first instance of a topic has its plain name, others are numbered: `sensor_gyro[1]`.

    Raises:
        BadInput: it is damaged from its beginning, or pyulog is missing.
    """
    pyulog = load_package("pyulog", path, "a PX4 log")
    try:
        return _log(pyulog.ULog(str(path)))
    except Exception as error:  # pyulog raises whatever its parser stumbles over
        raise BadInput(f"{path}: cannot be read as a PX4 log ({error}); download it again") from None


def _log(log: Any) -> Log:
    damaged = "the file is damaged, as after a logger lost its power: its readable part is used"
    topics, tables = list[Topic](), dict[str, Table]()
    for name, each in sorted((numbered(each.name, each.multi_id), each) for each in log.data_list):
        columns = {field: values.astype(np.float64) for field, values in each.data.items()}
        topics.append(Topic(name, each.name, tuple(columns), columns["timestamp"].size))
        tables[name] = Table(columns["timestamp"] * 1e-6, columns, {})
    return Log("PX4 ULog", tuple(topics), tables, (damaged,) if log.file_corruption else ())
