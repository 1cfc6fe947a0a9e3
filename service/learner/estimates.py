"""Estimates of the yaw rate without a gyro: answers to questions, and the published estimate."""

from __future__ import annotations

import numpy as np

from incsvr.errors import BadInput
from incsvr.signals.steps import refuse_steps
from service import wire
from service.learner.node import LearnerNode
from service.learner.published import check_trained
from service.learner.questions import refuse_effort
from service.learner.stand_in import ForecastFromStart


def forecast_reply(node: LearnerNode, asked: wire.ForecastQuery | None) -> wire.ForecastReply:
    """The answer to a question for a forecast.

    Args:
        asked: the torque that is planned; None for what came since the last measurement.

    Raises:
        NothingLearned: ask again later.
        BadInput: the question is none, or what a forecast needs does not come.
    """
    check_trained(node.served.model)
    stand_in, served, smoothing = node.stand_in, node.served, node.batches.smoothing
    believed = node.current_warnings.paused is None
    if asked is None:
        ahead = stand_in.since_measured(served.model, smoothing, believed)
    else:
        t, torque = np.array(asked.t), np.array(asked.torque)
        at = t if asked.at is None else np.array(asked.at)
        if t.size != torque.size:
            raise BadInput(f"t holds {t.size} times and torque {torque.size} values; give one for each")
        if (np.diff(t) < 0.0).any() or t[0] < 0.0 or (np.diff(at) < 0.0).any() or at[0] < 0.0:
            raise BadInput(
                "times are in seconds since the last measurement: let them begin at zero or later and increase"
            )
        refuse_steps(t, "the times of a plan")
        refuse_steps(at, "the times of the answers")
        refuse_effort(torque, node.config.vehicle.torque_limit, node.words)
        ahead = stand_in.under(served.model, smoothing, believed, t, torque, at)
    found = ahead.forecast
    return wire.ForecastReply(
        since=ahead.start.time,
        measured=ahead.start.rate,
        t=tuple(found.time.tolist()),
        rate=tuple(found.rate.tolist()),
        rate_low=tuple((found.rate - found.rate_half).tolist()),
        rate_high=tuple((found.rate + found.rate_half).tolist()),
        turned=tuple(found.turned.tolist()),
        turned_low=tuple((found.turned - found.turned_half).tolist()),
        turned_high=tuple((found.turned + found.turned_half).tolist()),
        worth=tuple(found.worth.tolist()),
        iteration=served.iteration,
        revision=served.revision,
    )


def estimate(node: LearnerNode, silent_s: float | None) -> wire.Estimate | None:
    """The estimate to publish while the gyro is silent or doubted; None if it is neither, or none is possible.

    Args:
        silent_s: for how long it has been silent, by the clock on the wall [s]; None where it is not.
    """
    paused = node.current_warnings.paused
    if (silent_s is None and paused is None) or not node.served.model.is_trained:
        return None
    try:
        ahead = node.stand_in.since_measured(node.served.model, node.batches.smoothing, paused is None)
    except BadInput:
        return None
    return _last(node, ahead, f"the {node.words.rate} is silent" if paused is None else f"learning is paused: {paused}")


def _last(node: LearnerNode, ahead: ForecastFromStart, why: str) -> wire.Estimate:
    found = ahead.forecast
    rate, half, turned, doubt = (
        float(values[-1]) for values in (found.rate, found.rate_half, found.turned, found.turned_half)
    )
    worth, age = bool(found.worth[-1]), float(found.time[-1]) - ahead.start.time
    left = (
        ""
        if worth
        else "; this estimate is too uncertain to be useful: its interval is as wide as the range of the usual rates"
    )
    return wire.Estimate(
        t=float(found.time[-1]),
        rate=rate,
        rate_low=rate - half,
        rate_high=rate + half,
        turned=turned,
        turned_low=turned - doubt,
        turned_high=turned + doubt,
        since=ahead.start.time,
        age_s=age,
        worth=worth,
        why=f"{why}; the last valid measurement is {age:.1f} s old{left}",
        iteration=node.served.iteration,
        revision=node.served.revision,
    )
