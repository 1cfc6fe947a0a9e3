"""Online model identification for underwater vehicles by incremental support vector regression.

The packages below are the mathematics alone: arrays in, arrays out. No bus, no files, no clock. Read top to bottom they
are the paper: B. Wehbe, A. Fabisch, M. M. Krell, "Online Model Identification for Underwater Vehicles through
Incremental Support Vector Regression", IROS 2017. "Eq." and "Section" in their docstrings cite that paper.

This file is the face for people who write Python. `fit`, `trace`, `identify` and `compare` are the functions that the
commands of these names call, `Learner` is the learner that `incsvr serve` runs, `read` reads a log. What reads files is
loaded when one of them is called, and not before.

    import incsvr

    log = {"t": t, "yaw_rate": r, "torque": tau}  # arrays, a DataFrame, or the path of a log of any format
    learned = incsvr.fit(log, inertia=350.0)
    print(learned.predict([0.05, 0.1]).damping, learned.score(other))
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, TypedDict, Unpack

from incsvr.errors import BadInput

if TYPE_CHECKING:
    from incsvr.learning.model import Model
    from incsvr.learning.prediction import Prediction
    from incsvr.learning.score import Residual, Score

__all__ = ["BadInput", "Fit", "Learner", "Log", "Result", "compare", "fit", "identify", "read", "trace"]

_FILES = "service.fitting.face"
"""The module that reads files: named, not imported, so that the mathematics stays free of it."""


class _PathLike(Protocol):
    def __fspath__(self) -> str: ...


class Result(Protocol):
    """The frozen result of a function of this module; `print` shows what its command prints."""

    def to_dict(self) -> dict[str, Any]:
        """The JSON that the command writes with `--json`."""

    def plot(self) -> Any:
        """A figure of matplotlib; BadInput says how matplotlib is installed where it is not."""

    def to_frame(self) -> Any:
        """A table as a DataFrame of pandas; BadInput says how pandas is installed where it is not."""


class Fit(Result, Protocol):
    """The result of `fit`."""

    @property
    def model(self) -> Model:
        """What was learned, frozen."""

    def predict(self, rate: Any) -> Prediction:
        """`damping`, `sigma` of one sample about it, its own `doubt` and `extrapolated` at a rate, or several."""

    def score(self, log: Logs) -> Score:
        """The errors on a log; where it was learned, they prove nothing."""

    def residual(self, log: Logs) -> Residual:
        """What the model leaves of a log."""

    def write(self, path: Path, *, name: str | None = None, state: Path | None = None, force: bool = False) -> str:
        """Writes a configuration from which `incsvr serve` and `Learner` continue, and says what was written."""


class Log(Result, Protocol):
    """A log that was read, and how: `fit` and `trace` read it again in the same way."""


Path: TypeAlias = str | _PathLike
OneLog: TypeAlias = Path | Log | Mapping[str, Any] | Any
"""A file; what `read` returned; arrays by the names of their columns, (n,) each, such as {"t": …, "yaw_rate": …,
"torque": …}, nan where a channel was not sampled; or a DataFrame with these columns."""
Logs: TypeAlias = OneLog | Sequence[OneLog]


class Reading(TypedDict, total=False):
    """Keywords that say what is in a log."""

    preset: str  # of the vehicle, such as "blueos" or "ros2", if the log does not show it
    column: str | Sequence[str]  # the source of a quantity, such as "yaw_rate=r:deg/s", or several
    system: str  # the vehicle to read, if a log contains several
    config: Path  # a configuration whose section `inputs` describes the log
    cut_from: float | str  # begin of the part that is used: seconds of the log, or a time of day as "14:05:30"
    cut_to: float | str  # its end


class Whole(Reading, total=False):
    """Keywords of `compare` and `identify`."""

    set: Mapping[str, Any]  # values of the configuration, such as {"signals.torque": "commanded"}


class Declared(Whole, total=False):
    """Keywords of `fit` and `trace`."""

    vehicle: Path  # a vehicle file, whose mass matrix is declared
    assume_sign: bool  # the torque's sign is used as recorded, even if the motion contradicts it


class Learning(Declared, total=False):
    """Keywords of `fit`."""

    policy: str  # "weighted" or "paper"
    effects: Path  # a result of `incsvr trace --json FILE`


def read(log: OneLog, *, axis: str | None = None, **how: Unpack[Reading]) -> Log:
    """A log as a recording.

    Args:
        log: a file of any format, arrays, or a DataFrame.
        axis: whose velocity and effort are meant; yaw without it.

    Returns:
        the recording; `to_dict` gives its columns as lists, None where a channel was not sampled.

    Raises:
        BadInput: naming the log, what is wrong or missing, and the cure.
    """
    found: Log = import_module(_FILES).read(log, {"axis": axis, **how})
    return found


def fit(
    logs: Logs,
    *,
    inertia: float | str | None = None,
    validate: Logs = (),
    axis: str | None = None,
    **more: Unpack[Learning],
) -> Fit:
    """The online loop over recordings: the damping curve of one axis.

    Args:
        logs: what is learned from, one run each.
        inertia: with added mass [kg m²], [kg]; "estimate" estimates it from open-loop runs; None as configured.
        validate: unseen runs, for the errors.
        axis: "surge", "sway", "heave", "roll", "pitch" or "yaw"; None as configured, which is yaw.

    Raises:
        BadInput: where the logs, or a keyword, cannot be used; one sentence with the cure.
    """
    found: Fit = import_module(_FILES).call("fit", logs, validate, {"inertia": inertia, "axis": axis, **more})
    return found


def trace(
    logs: Logs,
    *,
    inertia: float | str | None = None,
    validate: Logs = (),
    axis: str | None = None,
    **more: Unpack[Declared],
) -> Result:
    """The effects that the declared model of one axis lacks; arguments as of `fit`.

    Raises:
        BadInput: where the logs, or a keyword, cannot be used; one sentence with the cure.
    """
    found: Result = import_module(_FILES).call("trace", logs, validate, {"inertia": inertia, "axis": axis, **more})
    return found


def identify(
    logs: Logs, *, validate: Logs = (), name: str = "vehicle", vehicle: Path | None = None, **more: Unpack[Whole]
) -> Result:
    """The model of a whole vehicle, all axes together.

    Args:
        logs, validate: dives to fit, and dives for the errors alone.
        name: what the vehicle is called.
        vehicle: a vehicle file whose known entries of the mass matrix are declared.

    Raises:
        BadInput: where the logs, or a keyword, cannot be used; one sentence with the cure.
    """
    found: Result = import_module(_FILES).call("identify", logs, validate, {"name": name, "vehicle": vehicle, **more})
    return found


def compare(dives: Logs, **more: Unpack[Whole]) -> Result:
    """Inertias and drags of one vehicle, dive by dive, and in which dive they changed.

    Args:
        dives: two or more, in their order.

    Raises:
        BadInput: where the dives, or a keyword, cannot be used; one sentence with the cure.
    """
    found: Result = import_module(_FILES).call("compare", dives, (), more)
    return found


class Learner:
    """The learner of one axis as `incsvr serve` runs it, for a program that has no bus: the same settings and checks.

    Args:
        inertia: with added mass [kg m²], [kg].
        rate_range: the fastest velocity of the vehicle [rad/s], [m/s], or the lowest and the highest; the learner is
            scaled to it and to the inertia.
        axis: whose damping is learned; None as configured, which is yaw.
        config: a configuration file, such as `Fit.write` and `incsvr fit --write` leave.
        vehicle: a vehicle file of `incsvr identify --write`, whose learner of the axis it is.
        set: values of the configuration, such as {"learner.policy": "paper"}.

    Raises:
        BadInput: nobody said the inertia, or a keyword cannot be used; one sentence with the cure.
    """

    def __init__(
        self,
        *,
        inertia: float | None = None,
        rate_range: float | tuple[float, float] | None = None,
        axis: str | None = None,
        config: Path | None = None,
        vehicle: Path | None = None,
        set: Mapping[str, Any] | None = None,
    ) -> None:
        self._live = import_module(_FILES).live(inertia, rate_range, axis, config, vehicle, set or {})

    def push(self, t: Any, yaw_rate: Any, torque: Any, **channels: Any) -> bool:
        """Takes one measurement of each, or (n,) of them, and learns whatever batches they complete, from one thread.

        Args:
            t: stamps [s].
            yaw_rate: the velocity of the axis [rad/s], [m/s]; nan where it was not measured.
            torque: what the actuators apply along it [N m], [N]; nan where it was not measured.
            channels: further channels, by the names that the configuration lists in `signals.channels`.

        Returns:
            whether the model changed.

        Raises:
            BadInput: they are not of equal length.
        """
        return bool(self._live.push(t, {"yaw_rate": yaw_rate, "torque": torque, **channels}))

    def damping(self, rate: Any) -> Prediction:
        """The damping at (n,) velocities, or one.

        Raises:
            BadInput: nothing has been learned yet, or a velocity is not finite.
        """
        found: Prediction = self._live.damping(rate)
        return found

    @property
    def model(self) -> Model:
        """What is learned now, frozen: `is_trained` says whether it is anything."""
        found: Model = self._live.model
        return found

    @property
    def paused(self) -> str | None:
        """Why a batch is not believed and nothing is learned now; None while it learns."""
        found: str | None = self._live.paused
        return found

    def to_dict(self) -> dict[str, Any]:
        """The model in the form in which `incsvr serve` publishes it; empty before anything is learned."""
        found: dict[str, Any] = self._live.to_dict()
        return found
