"""The inertia where nobody declared it: that of the plain model, whose free course is brought near the measured one,
and that beside the effects that the plain model lacks.

The limits, to be said with the figures: both take the torque for true, so a thrust gain of g appears as I/g; both take
the torque for independent of disturbances, so they belong to open-loop runs; and where the vehicle hardly accelerates
the data say little about I, which the standard error then shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.errors import BadInput
from incsvr.model.identification import EFFECTS, identify, plain_fit, structure_of
from incsvr.model.intervals import halved, intervals
from incsvr.model.series import effort_of, values
from incsvr.model.simulation import predict
from incsvr.model.windows import cut
from incsvr.numerics import Streams, root_mean_square
from incsvr.plant.words import YAW_WORDS, AxisWords


@dataclass(frozen=True, slots=True)
class InertiaEstimate:
    """The inertia by output error, with its deviation.

    Attributes:
        inertia: I of the plain model, to which an effect that this model lacks adds [kg m²].
        standard_error: of I [kg m²], so large that 1.96 of it contain the interval of `beside`; the limits above come
            on top.
        rmse: of the plain model's free run on the runs it was fitted to [rad/s].
        effects: that the recordings show, by the engine's names.
        beside, beside_error: I beside these effects, and its standard error [kg m²].
    """

    inertia: float
    standard_error: float
    rmse: float
    effects: tuple[str, ...]
    beside: float
    beside_error: float


def estimate_inertia(
    runs: Sequence[Streams],
    words: AxisWords = YAW_WORDS,
    rate: str = "yaw_rate",
    fewest: int = 100,  # samples: fewer are fitted by anything
) -> InertiaEstimate:
    """The inertia of one axis.

    Args:
        runs: stretches without gaps of its velocity and its effort.
        words: what messages call the quantities of the axis.
        rate: the velocity's name in the runs.

    Raises:
        BadInput: the runs cannot tell the inertia.
    """
    runs = [run for run in runs if run[rate][0].size > 0.2 * fewest]
    recorded, efforts = (values(runs, name) if runs else np.empty(0) for name in (rate, effort_of(rate)))
    if recorded.size < fewest or np.ptp(recorded) == 0.0 or np.ptp(efforts) == 0.0:
        streams = f"{words.effort} and {words.rate}"
        raise BadInput(
            f"the {words.inertia} cannot be estimated: {streams} must change, over at least {fewest} samples"
        )
    # The longest windows: the push of the water that is in a window's start goes on, and looks like inertia.
    model = plain_fit(structure_of(runs, [rate]), runs, np.inf)
    one = intervals(model, [halved(model)])[f"mass:{rate}"]
    relative = float(np.log(one.high / one.low)) / (2.0 * 1.96)
    whole = cut(runs, model.structure, model.problem.windows.step, np.inf)
    point = np.array([model.theta[name] for name in model.names])[:, None]
    rmse = root_mean_square(whole.measured - predict(model.structure, point, whole, whole.starts[:, None])[:, 0])
    if not (rmse < 0.9 * float(np.std(recorded)) and relative < 0.5):
        raise BadInput(
            f"the {words.inertia} cannot be estimated: no free run follows these recordings; give open-loop runs in "
            f"which the vehicle speeds up and slows down, or declare the {words.inertia}"
        )
    found = identify(runs, [rate])
    if found.best != EFFECTS:
        return InertiaEstimate(one.value, one.value * relative, rmse, (), one.value, one.value * relative)
    two = intervals(found.model, [halved(found.model)])[f"mass:{rate}"]
    apart = max(abs(np.log(end / one.value)) for end in (two.low, two.high)) / 1.96
    effects = tuple(each.name for each in found.found.added)
    error = two.value * float(np.log(two.high / two.low)) / (2.0 * 1.96)
    return InertiaEstimate(one.value, one.value * max(relative, apart), rmse, effects, two.value, error)
