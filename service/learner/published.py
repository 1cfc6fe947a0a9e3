"""The learner's records of an iteration in the forms of the bus."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.coefficients import coefficients
from incsvr.learning.learner import Iteration
from incsvr.learning.model import Model
from incsvr.numerics import Array, root_mean_square
from incsvr.numerics.plain import or_none
from incsvr.plant.axes import YAW, Axis
from incsvr.signals.samples import Samples
from service import wire
from service.learner.questions import DampingQuery


class NothingLearned(BadInput):
    """There is no model yet."""


@dataclass(frozen=True, eq=False)
class ServedModel:
    """The model that queries are answered from; replaced as a whole."""

    model: Model
    revision: int
    iteration: int
    t: float | None  # the vehicle's time of the newest sample in it [s]
    effects: tuple[dict[str, Any], ...] = ()  # in force

    def reply_to(self, parameters: str) -> bytes | None:
        """The reply to `rate=` and one learned rate, the most frequent question, in a tenth of the time of
        `damping_reply`; None where that is to answer."""
        if not parameters.startswith("rate=") or "_" in parameters:
            return None
        try:
            rate = float(parameters[5:])
        except ValueError:
            return None
        found = self.model.one(rate)
        if found is None:
            return None
        damping, sigma, extrapolated, noise, derivative = found
        doubt = math.sqrt(max(sigma * sigma - noise * noise, 0.0))
        return (
            f'{{"rate":[{rate!r}],"damping":[{damping!r}],"sigma":[{sigma!r}],'
            f'"extrapolated":[{"true" if extrapolated else "false"}],"iteration":{self.iteration},'
            f'"revision":{self.revision},"doubt":[{doubt!r}],"derivative":[{derivative!r}]}}'
        ).encode()


def check_trained(model: Model) -> None:
    """Raises NothingLearned where there is no model yet."""
    if not model.is_trained:
        raise NothingLearned("nothing has been learned yet; ask again once a first batch of samples is complete")


def snapshot(served: ServedModel, boot: str, inertia: float) -> wire.ModelSnapshot:
    """The model that is served, learned with this inertia [kg m²], and its traced effects."""
    model = served.model
    return wire.ModelSnapshot(
        boot=boot,
        revision=served.revision,
        iteration=served.iteration,
        t=served.t or 0.0,
        kernel=wire.Kernel(gamma=model.gamma),
        epsilon=model.epsilon,
        C=model.C,
        support=wire.Support(
            rate=tuple(model.support_rate.tolist()),
            damping=tuple(model.support_damping.tolist()),
            weight=tuple(model.weight.tolist()),
            count=tuple(model.count.tolist()),
            others={name: tuple(values.tolist()) for name, values in model.others_at_support.items()},
        ),
        inertia=inertia,
        effects=served.effects,
        noise=_finite(model.sigma),
        trained_range=model.trained_range,
        certified_error=_finite(model.certified_error) if model.is_trained else None,
        correlation=model.correlation,
        water=model.water,
        spread=model.spread,
        widening=model.widening,
        over=_over(model),
    )


def _over(model: Model) -> wire.OverSeveral | None:
    """The fields of a model over several velocities beside its vectors."""
    several = model.several
    if several is None:
        return None
    return wire.OverSeveral(
        inputs=(several.own, *several.others),
        fastest=tuple(several.fastest.tolist()),
        drag=tuple(several.drag.tolist()),
        trained_ranges=several.ranges,
    )


def textbook_coefficients(served: ServedModel, boot: str) -> wire.Coefficients:
    """The textbook's coefficients of the model that is served; none where all that was learned was taken back."""
    found = coefficients(served.model) if served.model.is_trained else {}
    return wire.Coefficients(
        boot=boot,
        revision=served.revision,
        iteration=served.iteration,
        t=served.t or 0.0,
        coefficients={name: wire.Coefficient(**each._asdict()) for name, each in found.items()},
        trained_range=served.model.trained_range,
    )


def damping_reply(model: Model, asked: DampingQuery, iteration: int, revision: int) -> wire.DampingReply:
    """The reply of a model of this iteration and revision to a question for damping.

    Raises:
        NothingLearned: ask again later.
        BadInput: it is asked over other velocities than the model's.
    """
    check_trained(model)
    rate, *further = asked.columns(model)
    several = model.several
    prediction = model.predict(rate) if several is None else model.over(np.column_stack((rate, *further)))
    return wire.DampingReply(
        rate=rate,
        others={} if several is None else dict(zip(several.others, further, strict=True)),
        damping=tuple(prediction.damping.tolist()),
        sigma=tuple(prediction.sigma.tolist()),
        doubt=tuple(prediction.doubt.tolist()),
        extrapolated=tuple(prediction.extrapolated.tolist()),
        derivative=tuple(prediction.derivative.tolist()),
        iteration=iteration,
        revision=revision,
    )


def report(
    iteration: Iteration,
    batch: Samples,
    served: ServedModel,
    *,
    boot: str,
    predicted: Array | None,
    training_s: float,
    validation: Mapping[str, Samples],
    learned: float,
    axis: Axis = YAW,
) -> wire.IterationReport:
    """One iteration with the batch that it learned from.

    Args:
        served: what is served after it.
        predicted: (n,) what was served before it said of the batch [N m]; None where nothing was.
        training_s: how long it took [s].
        validation: samples that the served model's error is measured on, by name.
        learned: how much of the rate range fresh samples cover.
        axis: in whose words it says what was noticed.
    """
    sets: dict[str, Samples] = {name: getattr(iteration, name) for name in wire.SETS}
    return wire.IterationReport(
        boot=boot,
        revision=served.revision,
        iteration=iteration.number,
        t=float(batch.time[-1]),
        time_span=iteration.time_span,
        trained=iteration.trained,
        training_ms=1e3 * training_s,
        counts={name: len(samples) for name, samples in sets.items()}
        | {"undriven": len(iteration.undriven), "batch": len(batch)},
        **{name: _points(samples) for name, samples in sets.items()},
        batch=wire.Batch(
            time=tuple(batch.time.tolist()),
            rate=tuple(batch.yaw_rate.tolist()),
            damping=tuple(batch.damping.tolist()),
            predicted=None if predicted is None else tuple(predicted.tolist()),
            channels={name: or_none(values) for name, values in batch.channels.items()},
            parts={name: tuple(values.tolist()) for name, values in batch.parts.items()},
        ),
        certified_error=_finite(iteration.model.certified_error),
        progressive_mae=None if predicted is None else float(np.mean(np.abs(predicted - batch.damping))),
        noise=_finite(iteration.model.sigma),
        validation=tuple(_error_on(name, samples, served.model) for name, samples in validation.items()),
        learned=learned,
        change=iteration.change,
    )


def _error_on(name: str, samples: Samples, model: Model) -> wire.Validation:
    residual = model.at(samples).damping - samples.damping
    return wire.Validation(
        name=name,
        mae=float(np.mean(np.abs(residual))),
        rmse=root_mean_square(residual),
        samples=len(samples),
        untrained=float(np.mean(np.abs(samples.damping))),
    )


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _points(samples: Samples) -> wire.Points:
    return wire.Points(
        rate=tuple(samples.yaw_rate.tolist()),
        damping=tuple(samples.damping.tolist()),
        others={name: tuple(values.tolist()) for name, values in samples.channels.items()},
    )
