"""Arrays and data frames as logs: their columns are named as those of a recording, and read as those of a table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.inputs.table import Table
from service.logs.log import Log, table_log


@dataclass(frozen=True, slots=True)
class Arrays:
    """A log of arrays in memory.

    Attributes:
        name: what its refusals call it.
        log: what is in it.
    """

    name: str
    log: Log = field(repr=False)

    def __str__(self) -> str:
        return self.name

    @staticmethod
    def of(name: str, given: Any) -> Arrays | None:
        """A mapping of names to (n,) values, or a data frame, as a log; None where it is neither.

        Raises:
            BadInput: a column is no list of numbers, or of another length than the others.
        """
        if isinstance(given, Mapping):
            columns = dict(given)
        elif hasattr(given, "columns") and hasattr(given, "__getitem__"):
            columns = {str(each): given[each] for each in given.columns}
        else:
            return None
        found = {str(column): _values(name, str(column), values) for column, values in columns.items()}
        if not found:
            raise BadInput(f'{name}: there is no column; give {{"t": …, "yaw_rate": …, "torque": …}}')
        sizes = {column: values.size for column, values in found.items()}
        first = next(iter(sizes))
        for column, size in sizes.items():
            if size != sizes[first]:
                raise BadInput(
                    f"{name}: {first} has {sizes[first]} values and {column} has {size}; give one value for each "
                    "time, and nan where a channel was not sampled"
                )
        if sizes[first] < 2:
            raise BadInput(f"{name}: there are no rows; give at least a few seconds")
        return Arrays(name, table_log("arrays", Table(None, found, {})))


def _values(name: str, column: str, given: Any) -> Array:
    """A column as numbers; instants become seconds since 1970."""
    values = np.asarray(given)
    if values.dtype.kind == "M":
        seconds = values.astype("datetime64[ns]").astype(np.float64) / 1e9
        return np.where(np.isnat(values), np.nan, seconds)
    try:
        found = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadInput(f"{name}: {column} holds what is no number; leave the column out, or convert it") from None
    if found.ndim != 1:
        raise BadInput(f"{name}: {column} has {found.ndim} dimensions; give one value for each time")
    infinite = np.flatnonzero(np.isinf(found))
    if infinite.size:
        raise BadInput(f"{name}: {column}[{infinite[0]}] is {found[infinite[0]]}; give nan where nothing was sampled")
    return found
