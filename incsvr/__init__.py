"""Online model identification for underwater vehicles by incremental support vector regression.

The packages below are the mathematics alone: arrays in, arrays out. No bus, no files, no clock. Read top to bottom they
are the paper: B. Wehbe, A. Fabisch, M. M. Krell, "Online Model Identification for Underwater Vehicles through
Incremental Support Vector Regression", IROS 2017. "Eq." and "Section" in their docstrings cite that paper.

This file is the face for people who write Python. `read`, `fit`, `trace`, `identify` and `compare` are the commands of
these names, with their flags as keywords; what reads files is loaded when one of them is called, and not before.

    import incsvr

    log = incsvr.read("dive.csv")
    found = incsvr.trace(log, inertia=350.0)
    print(found.to_dict()["headline"])
    found.plot().savefig("trace.png")
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any, Protocol, TypeAlias

from incsvr.errors import BadInput

__all__ = ["BadInput", "Fit", "Log", "Result", "compare", "fit", "identify", "read", "trace"]

_FILES = "service.commands.python_api"
"""The module that reads files and calls the commands: named, not imported, so that the mathematics stays free of it."""


class _PathLike(Protocol):
    def __fspath__(self) -> str: ...


class Result(Protocol):
    """The frozen result of a function of this module."""

    def to_dict(self) -> dict[str, Any]:
        """The JSON that the command writes with `--json`."""

    def plot(self) -> Any:
        """A figure of matplotlib; BadInput says how matplotlib is installed where it is not."""

    def to_frame(self) -> Any:
        """A table as a DataFrame of pandas; BadInput says how pandas is installed where it is not."""


class Fit(Result, Protocol):
    """The result of `fit`."""

    def predict(self, rate: Any) -> Any:
        """`damping`, `sigma` of one sample about it, its own `doubt` and `extrapolated` at a rate, or several."""


class Log(Result, Protocol):
    """A log that was read, and how: `fit` and `trace` read it again in the same way."""


Path: TypeAlias = str | _PathLike
Logs: TypeAlias = Path | Log | Sequence[Path | Log]


def read(log: Path, **how: Any) -> Log:
    """A log of any format as a recording.

    Args:
        log: the file.
        how: the flags of `incsvr fit` by which one says what is in a log: `preset`, `column` (one text such as
            "yaw_rate=r:deg/s", or several), `system`, `axis`.

    Returns:
        the recording; `to_dict` gives its columns as lists, None where a channel was not sampled.

    Raises:
        BadInput: naming the file, what is wrong or missing, and the cure.
    """
    found: Log = import_module(_FILES).read(log, **how)
    return found


def fit(recordings: Logs, *, validate: Logs = (), **flags: Any) -> Fit:
    """The online loop over recordings, as `incsvr fit` runs it.

    Args:
        recordings: logs to learn from, files or what `read` returned, one run each.
        validate: unseen runs, for the errors.
        flags: those of the command, by name: `inertia` (a number [kg m²], or "estimate"), `vehicle`, `config`,
            `policy`, `effects`, `write`, …; `set` is a mapping, such as {"signals.torque": "commanded"}.

    Raises:
        BadInput: where the recordings, or a flag, cannot be used; one sentence with the cure.
    """
    found: Fit = import_module(_FILES).fit(recordings, validate, flags)
    return found


def trace(recordings: Logs, *, validate: Logs = (), **flags: Any) -> Result:
    """The effects that the declared model lacks, as `incsvr trace` finds them; arguments as of `fit`.

    Args:
        recordings, validate: runs to fit, and unseen recordings, used for validation alone.
        flags: those of the command, by name: `inertia`, `vehicle`, `set`, `manoeuvre`, …

    Raises:
        BadInput: where the recordings, or a flag, cannot be used; one sentence with the cure.
    """
    found: Result = import_module(_FILES).trace(recordings, validate, flags)
    return found


def identify(recordings: Logs, *, validate: Logs = (), **flags: Any) -> Result:
    """The model of a whole vehicle, all axes together, as `incsvr identify` finds it.

    Args:
        recordings, validate: dives to fit, and dives for the errors alone.
        flags: those of the command, by name: `name`, `vehicle`, `set`, `write`, …

    Raises:
        BadInput: where the recordings, or a flag, cannot be used; one sentence with the cure.
    """
    found: Result = import_module(_FILES).identify(recordings, validate, flags)
    return found


def compare(dives: Logs, **flags: Any) -> Result:
    """Inertias and drags of one vehicle, dive by dive, and in which dive they changed, as `incsvr compare` finds them.

    Args:
        dives: two or more, in their order.
        flags: those of the command, by name: `set`, `table`, `column`, …

    Raises:
        BadInput: where the dives, or a flag, cannot be used; one sentence with the cure.
    """
    found: Result = import_module(_FILES).compare(dives, flags)
    return found
