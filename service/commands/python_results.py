"""What a call of `import incsvr` returns: frozen results that are printed, drawn, and made into tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from numpy.typing import ArrayLike

from incsvr.errors import BadInput
from incsvr.free_run.fit_pictures import FitPictures
from incsvr.learning.prediction import Prediction
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.terms import mass_unit
from incsvr.tracing.findings import Trace
from incsvr.vehicle import Comparison, Identified
from service.cli.extras import how_to_install
from service.commands.report_head import PLOTS
from service.inputs.quantities import si_unit
from service.recordings.recording import Recording


@dataclass(frozen=True, slots=True, repr=False)
class Log:
    """A log that was read.

    Attributes:
        path: the file.
        recording: what is in it.
        flags: how it was read.
    """

    path: Path
    recording: Recording
    flags: tuple[str, ...] = ()

    def __repr__(self) -> str:
        time, names = self.recording.time, [name for name in self.to_dict()["columns"] if name != "t"]
        return f"{self.recording.name}: {float(time[-1] - time[0]):.4g} s of {', '.join(names)}"

    def to_dict(self) -> dict[str, Any]:
        """The columns by name, `t` first, None where a channel was not sampled; and what is to be known of them."""
        recording = self.recording
        own = dict(zip((YAW.rate, YAW.effort), (recording.axis.rate, recording.axis.effort), strict=True))
        columns = {own.get(name, name): values for name, values in recording.columns.items()}
        columns = {"t": recording.time, **columns, **recording.displaced}
        return {
            "name": recording.name,
            "axis": recording.axis.name,
            "columns": {name: [None if v != v else v for v in values.tolist()] for name, values in columns.items()},
            "notes": list(recording.notes),
        }

    def plot(self) -> Any:
        """Velocity and torque over time, as a figure of matplotlib."""
        streams = self.recording.streams()
        axis = self.recording.axis
        drawn = {axis.rate: streams[YAW.rate], axis.effort: streams[YAW.effort]}
        return _plots().of_log(self.recording.name, drawn, {name: si_unit(name) for name in drawn})

    def to_frame(self) -> Any:
        """The columns as a DataFrame of pandas."""
        return _frame(self.to_dict()["columns"])


@dataclass(frozen=True, slots=True, repr=False)
class CommandResult:
    """The result of a command; `str` and `repr` are the printed text.

    Attributes:
        result: what it writes with `--json`.
        text: what it prints.
        axis: whose words both are in.
    """

    result: Mapping[str, Any]
    text: str
    axis: Axis

    def __repr__(self) -> str:
        return self.text

    def to_dict(self) -> dict[str, Any]:
        """The JSON that the command writes with `--json`."""
        return dict(self.result)


@dataclass(frozen=True, slots=True, repr=False)
class FitResult(CommandResult):
    """The result of `fit`."""

    pictures: FitPictures

    def plot(self) -> Any:
        """The damping curve beside its samples, as a figure of matplotlib."""
        return _plots().of_fit(self.pictures, self.axis)

    def to_frame(self) -> Any:
        """The damping curve as a DataFrame of pandas: rate, damping, sigma of a sample about it and its own doubt."""
        return _frame(self.result["curve"])

    def predict(self, rate: ArrayLike) -> Prediction:
        """Damping, sigma, doubt and whether it is extrapolated at (n,) rates, or one."""
        return self.pictures.model.predict(rate)


@dataclass(frozen=True, slots=True, repr=False)
class TraceResult(CommandResult):
    """The result of `trace`."""

    trace: Trace

    def plot(self) -> Any:
        """The damping, and a free run, before and after, as a figure of matplotlib."""
        return _plots().of_trace(self.trace, self.axis)

    def to_frame(self) -> Any:
        """One row for each parameter of each effect, as a DataFrame of pandas."""
        return _frame(
            [
                {
                    "effect": each["effect"], "parameter": name, "estimate": value,
                    **dict(zip(("low", "high"), each["interval"].get(name, (None, None)), strict=True)),
                    "p_value": each["p_value"], "share": each["share"],
                }
                for each in self.result["effects"]
                for name, value in each["parameters"].items()
            ],
            ("effect", "parameter", "estimate", "low", "high", "p_value", "share"),
        )  # fmt: skip


@dataclass(frozen=True, slots=True, repr=False)
class IdentifyResult(CommandResult):
    """The result of `identify`: the model of a whole vehicle."""

    identified: Identified

    def plot(self) -> Any:
        """Prediction errors of every axis some seconds ahead, as a figure of matplotlib."""
        return _plots().of_vehicle(self.identified)

    def to_frame(self) -> Any:
        """One row for each parameter of each axis, with its interval, as a DataFrame of pandas."""
        vehicle = self.identified.vehicle
        named = [
            (one, "inertia" if one == other else f"inertia with {other}", mass_unit(one, other), parameter)
            for (one, other), parameter in vehicle.mass.items()
        ]
        named += [(term.axis, term.name, term.unit, parameter) for term, parameter in vehicle.terms.items()]
        named += [(axis, "thrust lag", "s", parameter) for axis, parameter in vehicle.lags.items()]
        rows = [{"axis": axis, "parameter": name, "unit": unit, **p.to_dict()} for axis, name, unit, p in named]
        return _frame(rows)


@dataclass(frozen=True, slots=True, repr=False)
class CompareResult(CommandResult):
    """The result of `compare`: the dives of one vehicle."""

    compared: Comparison

    def plot(self) -> Any:
        """Inertia and drag of every axis over the dives, with intervals, as a figure of matplotlib."""
        return _plots().of_comparison(self.compared)

    def to_frame(self) -> Any:
        """One row for each dive and quantity, as a DataFrame of pandas."""
        return _frame(self.compared.rows())


def _frame(data: Mapping[str, Any] | Sequence[Mapping[str, Any]], columns: Sequence[str] | None = None) -> Any:
    """A DataFrame of columns by name, or of rows; `columns` names them where there may be no row."""
    try:
        pandas = import_module("pandas")
    except ModuleNotFoundError:
        raise BadInput(f"to_frame() needs pandas, which is not installed: {how_to_install('pandas')}") from None
    return pandas.DataFrame(data, columns=columns)


def _plots() -> ModuleType:
    return import_module(PLOTS)
