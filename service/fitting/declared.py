"""What is declared of the vehicle: its inertia, configured, given or estimated; or the mass matrix of its body."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from incsvr.errors import BadInput
from incsvr.forecasting.over_recordings import motions
from incsvr.model.inertia import InertiaEstimate, estimate_inertia
from incsvr.plant.axes import Axis
from incsvr.plant.body import Coupled
from incsvr.plant.words import AxisWords, words_of
from incsvr.signals import TORQUE, YAW_RATE
from incsvr.signals.settings import TorqueKind
from incsvr.tracing.vocabulary import contract_name
from service.cli.progress import progress
from service.config.configuration import Config
from service.fitting.cures import cure
from service.fitting.other_velocities import coupled_axis
from service.fitting.request import Request
from service.number import decimal_comma, number_of
from service.recordings.recording import Recording
from service.recordings.samples_from_recording import signals_for

ESTIMATE = "estimate"
ESTIMATE_LIMITS = "the estimate assumes a correct {effort} and open-loop runs: a thrust gain of g appears as I/g"
CLOSED_LOOP_DOUBT = (
    "closed loop: the {effort} reacts to disturbances of the {rate}, so a free run cannot validate the estimated "
    "{inertia}, which may be off by half its value and more; declare the {inertia}, or record open-loop runs"
)
"""Templates of `AxisWords`."""


@dataclass(frozen=True, slots=True)
class Declared:
    """The vehicle as it is declared.

    Attributes:
        inertia: I with added mass [kg m²], [kg].
        estimate: how it was estimated, where it was.
        coupled: the axis in its body, where its mass matrix or its weight is declared.
        torque: what the torque is, where a person said it.
    """

    inertia: float
    estimate: InertiaEstimate | None = None
    coupled: Coupled | None = None
    torque: TorqueKind | None = None

    @staticmethod
    def of(
        request: Request, config: Config, axis: Axis, runs: Sequence[Recording], every: Sequence[Recording]
    ) -> Declared:
        """What a request and its configuration declare.

        Args:
            runs: to estimate the inertia from.
            every: all recordings, whose velocities a body needs.

        Raises:
            BadInput: nobody gave the inertia, it is no positive number, or the runs do not tell it; a body is declared
                as well.
        """
        wanted, torque = request.inertia, request.torque_set(config)
        coupled = coupled_axis(config, axis, every)
        if coupled is not None and wanted is not None:
            has = f"the body that is declared has {coupled.inertia:g}"
            raise BadInput(f"--inertia {wanted}: {has}; {cure('inertia twice', axis)}")
        if coupled is not None:
            return Declared(coupled.inertia, None, coupled, torque)
        if wanted is None:
            if not config.vehicle.inertia_said:
                raise BadInput(f"the {words_of(axis).inertia} is not known; {cure('inertia', axis)}")
            return Declared(config.vehicle.inertia, torque=torque)
        if wanted != ESTIMATE:
            return Declared(positive(wanted, words_of(axis)), torque=torque)
        estimate = _estimated(runs, axis, torque)
        return Declared(estimate.inertia, estimate, None, torque)

    @property
    def as_written(self) -> Declared:
        """With an estimate to the digits that are written down."""
        return self if self.estimate is None else replace(self, inertia=float(f"{self.inertia:.5g}"))

    @property
    def beside_effects(self) -> Declared:
        """With the estimate of a model that has the effects which the recordings show."""
        return self if self.estimate is None else replace(self, inertia=self.estimate.beside)

    def in_force(self, config: Config) -> Config:
        """The configuration of a vehicle with this inertia, or in this body."""
        mass = None if self.coupled is None else tuple(self.coupled.mass.ravel().tolist())
        vehicle = config.vehicle.model_copy(update={"inertia": self.inertia, "mass_matrix": mass})
        return config.model_copy(update={"vehicle": vehicle})


def _estimated(runs: Sequence[Recording], axis: Axis, torque: TorqueKind | None) -> InertiaEstimate:
    """The inertia by output error over the runs, each from its first velocity."""
    signals = signals_for(runs, 1.0, axis.fastest, torque)
    found = [motion for run in runs for motion in motions(run.streams(), signals.longest_pause)]
    streams = [{YAW_RATE: (one.rate_time, one.yaw_rate), TORQUE: (one.torque_time, one.torque)} for one in found]
    with progress("estimating the inertia"):
        return estimate_inertia(streams, words_of(axis))


def positive(given: str, words: AxisWords) -> float:
    """A number above zero; argparse would answer a word with its usage, not with one sentence."""
    try:
        value = number_of(given)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        what = f"the {words.moment_of_inertia} in {words.inertia_unit}"
        raise BadInput(f"--inertia is {given}; give {what}, a positive number, or estimate{decimal_comma(given)}")
    return value


def estimate_in_result(estimate: InertiaEstimate | None, closed_loop: bool) -> dict[str, Any]:
    """The fields that an estimate adds to the result of a fit; in closed loop it has no standard error."""
    if estimate is None:
        return {}
    error = None if closed_loop else estimate.standard_error
    return {"inertia_standard_error": error, "fit_free_run_rmse": estimate.rmse}


def estimate_remarks(estimate: InertiaEstimate, closed_loop: bool, words: AxisWords) -> list[str]:
    """The remarks on an estimated inertia."""
    said = [words.fill(ESTIMATE_LIMITS), *([words.fill(CLOSED_LOOP_DOUBT)] if closed_loop else [])]
    if estimate.effects:
        shown = " and ".join(dict.fromkeys(contract_name(each) for each in estimate.effects))
        said.append(
            f"the recordings show {shown}, which this model replaces by {words.inertia}: beside it "
            f"{words.inertia_symbol} is {estimate.beside:.3g} ± {1.96 * estimate.beside_error:.2g} {words.inertia_unit}"
        )
    return said


def doubt(error: float, closed_loop: bool) -> str:
    """Half the interval of 95 %, beside a figure with a standard error."""
    return "" if closed_loop else f" ± {1.96 * error:.2g}"
