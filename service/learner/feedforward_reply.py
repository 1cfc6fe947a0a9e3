"""The answer to a question for the torque that drives a planned yaw rate."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.prediction import Prediction
from incsvr.numerics import Array
from service import wire
from service.learner.damping_query import MAX_RATE, DampingQuery
from service.learner.node import LearnerNode
from service.learner.published import ServedModel, check_trained

NOT_IN_A_BODY = (
    "what the body's other velocities and its attitude take (vehicle.mass_matrix, vehicle.weight) is not in this "
    "{effort}"
)
"""A template of `AxisWords`."""


def feedforward_reply(
    node: LearnerNode, asked: wire.FeedforwardQuery, velocities: Mapping[str, str]
) -> wire.FeedforwardReply:
    """The torque that drives a planned motion.

    Args:
        node: the learner.
        asked: the plan.
        velocities: what a velocity may be called in a question → its stream (`velocity_names`).

    Raises:
        NothingLearned: ask again later.
        BadInput: the plan is none.
    """
    # Loaded where it is needed alone: it brings the catalogue of effects with it.
    from incsvr.compensation.feedforward import Plan, feedforward, plan_words

    served, compensation = node.served, node.batches.compensation
    check_trained(served.model)
    channels = {velocities.get(name, name): np.array(values) for name, values in asked.channels.items()}
    acceleration = None if asked.acceleration is None else np.array(asked.acceleration)
    plan = Plan.of(np.array(asked.t), np.array(asked.rate), acceleration, channels)
    if not np.abs(plan.rate).max() <= MAX_RATE:
        unit = node.words.rate_unit
        raise BadInput(f"a rate beyond {MAX_RATE:g} {unit} is planned; plan in {unit}")
    learned = _prediction(served, plan.rate, plan.channels)
    found = feedforward(plan, learned.damping, learned.sigma, node.config.vehicle.inertia, compensation, node.words)
    remarks = list(found.remarks)
    if learned.extrapolated.any():
        remarks.append(f"{plan_words(plan, learned.extrapolated)}: the damping there is not learned but extrapolated")
    if node.config.coupled() is not None:
        remarks.append(node.words.fill(NOT_IN_A_BODY))
    there = found.at(np.array(asked.t))
    return wire.FeedforwardReply(
        t=asked.t,
        torque=tuple(there.torque.tolist()),
        low=tuple(there.low.tolist()),
        high=tuple(there.high.tolist()),
        inertia_part=tuple(there.inertia_part.tolist()),
        damping_part=tuple(there.damping_part.tolist()),
        effects_part=tuple((there.torque - there.inertia_part - there.damping_part).tolist()),
        effects={name: tuple(values.tolist()) for name, values in there.effects.items()},
        lead_s=there.lead,
        told=tuple(remarks),
        iteration=served.iteration,
        revision=served.revision,
    )


def _prediction(served: ServedModel, rate: Array, channels: Mapping[str, Array]) -> Prediction:
    """The model along a plan; of a further velocity that is not planned as is usual where it learned."""
    several = served.model.several
    if several is None:
        return served.model.predict(rate)
    others = {name: tuple(channels[name].tolist()) for name in several.others if name in channels}
    return served.model.over(np.column_stack(DampingQuery(tuple(rate.tolist()), others).columns(served.model)))
