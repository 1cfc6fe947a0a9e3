"""The learner's records of an iteration in the forms of the bus."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.coefficients import coefficients
from incsvr.learning.learner import Iteration
from incsvr.learning.model import Model
from incsvr.numerics import Array, root_mean_square
from incsvr.numerics.plain import or_none
from incsvr.plant.axes import Axis
from incsvr.signals.samples import Samples
from service import wire
from service.learner.questions import columns


class NothingLearned(BadInput):
    """There is no model yet."""


def reply_to(served: wire.ModelSnapshot, parameters: str) -> bytes | None:
    """The reply to `rate=` and one learned rate, the most frequent question, in a tenth of the time of
    `damping_reply`; None where that is to answer."""
    if not parameters.startswith("rate=") or "_" in parameters:
        return None
    try:
        rate = float(parameters[5:])
    except ValueError:
        return None
    found = served.model.one(rate)
    if found is None:
        return None
    damping, sigma, extrapolated, noise, derivative = found
    doubt = math.sqrt(max(sigma * sigma - noise * noise, 0.0))
    return (
        f'{{"rate":[{rate!r}],"damping":[{damping!r}],"sigma":[{sigma!r}],'
        f'"extrapolated":[{"true" if extrapolated else "false"}],"iteration":{served.iteration},'
        f'"revision":{served.revision},"doubt":[{doubt!r}],"derivative":[{derivative!r}]}}'
    ).encode()


def check_trained(model: Model) -> None:
    """Raises NothingLearned where there is no model yet."""
    if not model.is_trained:
        raise NothingLearned("nothing has been learned yet; ask again once a first batch of samples is complete")


def textbook_coefficients(served: wire.ModelSnapshot) -> wire.Coefficients:
    """The textbook's coefficients of the model that is served; none where all that was learned was taken back."""
    found = coefficients(served.model) if served.model.is_trained else {}
    return wire.Coefficients(
        boot=served.boot,
        revision=served.revision,
        iteration=served.iteration,
        t=served.t or 0.0,
        coefficients={name: wire.Coefficient(**each._asdict()) for name, each in found.items()},
        trained_range=served.model.trained_range,
    )


def damping_reply(served: wire.ModelSnapshot, asked: wire.DampingQuery) -> wire.DampingReply:
    """The reply of a model to a question for damping.

    Raises:
        NothingLearned: ask again later.
        BadInput: it is asked over other velocities than the model's.
    """
    model = served.model
    check_trained(model)
    rate, *further = columns(asked, model)
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
        iteration=served.iteration,
        revision=served.revision,
    )


def report(
    iteration: Iteration,
    batch: Samples,
    served: wire.ModelSnapshot,
    predicted: Array | None,
    axis: Axis,
    validation: Mapping[str, Samples],
    learned: float,
    training_s: float = 0.0,
) -> wire.IterationReport:
    """One iteration with the batch that it learned from.

    Args:
        served: what is served after it.
        predicted: (n,) what was served before it said of the batch [N m]; None where nothing was.
        axis: in whose words it says what was noticed.
        validation: samples that the served model's error is measured on, by name.
        learned: how much of the rate range fresh samples cover.
        training_s: how long it took [s].
    """
    sets: dict[str, Samples] = {name: getattr(iteration, name) for name in wire.SETS}
    points: dict[str, Any] = {name: wire.Points.of(samples) for name, samples in sets.items()}
    return wire.IterationReport(
        boot=served.boot,
        revision=served.revision,
        iteration=iteration.number,
        t=float(batch.time[-1]),
        time_span=iteration.time_span,
        trained=iteration.trained,
        training_ms=1e3 * training_s,
        counts={name: len(samples) for name, samples in sets.items()}
        | {"undriven": len(iteration.undriven), "batch": len(batch)},
        **points,
        batch=wire.Batch(
            time=tuple(batch.time.tolist()),
            rate=tuple(batch.yaw_rate.tolist()),
            damping=tuple(batch.damping.tolist()),
            predicted=None if predicted is None else tuple(predicted.tolist()),
            channels={name: or_none(values) for name, values in batch.channels.items()},
            parts={name: tuple(values.tolist()) for name, values in batch.parts.items()},
        ),
        certified_error=iteration.model.certified_error,
        progressive_mae=None if predicted is None else float(np.mean(np.abs(predicted - batch.damping))),
        noise=served.noise,
        validation=tuple(
            _error_on(name, samples, served.model) for name, samples in validation.items() if served.model.is_trained
        ),
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
