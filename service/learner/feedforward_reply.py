"""The answer to a question for the torque that drives a planned yaw rate."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.prediction import Prediction
from incsvr.numerics import Array
from incsvr.signals.streams import JUMP_S
from service import wire
from service.learner.node import LearnerNode
from service.learner.published import check_trained
from service.learner.questions import MAX_RATE, refuse_effort


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
        BadInput: the plan is none, or a velocity that it needs is neither planned nor measured.
    """
    # Loaded where it is needed alone: it brings the catalogue of effects with it.
    from incsvr.compensation.feedforward import Plan, feedforward, plan_words

    served, compensation = node.served, node.batches.compensation
    check_trained(served.model)
    coupled = node.config.coupled()
    channels = {velocities.get(name, name): np.array(values) for name, values in asked.channels.items()}
    needed = dict.fromkeys((*node.config.further_inputs, *(() if coupled is None else coupled.streams)))
    held = {name: _present(node, name) for name in needed if name not in channels}
    channels |= {name: np.full(len(asked.t), value) for name, value in held.items()}
    acceleration = None if asked.acceleration is None else np.array(asked.acceleration)
    plan = Plan.of(np.array(asked.t), np.array(asked.rate), acceleration, channels)
    if not np.abs(plan.rate).max() <= MAX_RATE:
        unit = node.words.rate_unit
        raise BadInput(f"a rate beyond {MAX_RATE:g} {unit} is planned; plan in {unit}")
    learned = _prediction(served, plan.rate, plan.channels)
    found = feedforward(
        plan, learned.damping, learned.sigma, node.config.vehicle.inertia, compensation, node.words, coupled
    )
    refuse_effort(found.torque, node.config.vehicle.torque_limit, node.words)
    remarks = [f"{name} is not planned: it is held at {value:.3g}, as last measured" for name, value in held.items()]
    remarks += found.remarks
    if learned.extrapolated.any():
        remarks.append(f"{plan_words(plan, learned.extrapolated)}: the damping there is not learned but extrapolated")
    if coupled is not None and coupled.missing:
        remarks.append(f"nothing sends {', '.join(coupled.missing)}: it counts as zero, as in the learned damping")
    there = found.at(np.array(asked.t))
    return wire.FeedforwardReply(
        t=asked.t,
        torque=tuple(there.torque.tolist()),
        low=tuple(there.low.tolist()),
        high=tuple(there.high.tolist()),
        inertia_part=tuple(there.inertia_part.tolist()),
        body_part=tuple(there.body_part.tolist()),
        damping_part=tuple(there.damping_part.tolist()),
        effects_part=tuple((there.torque - there.inertia_part - there.body_part - there.damping_part).tolist()),
        effects={name: tuple(values.tolist()) for name, values in there.effects.items()},
        lead_s=there.lead,
        told=tuple(remarks),
        iteration=served.iteration,
        revision=served.revision,
    )


def _present(node: LearnerNode, name: str) -> float:
    """The last measured value of a velocity or an angle that is not planned.

    Raises:
        BadInput: there is none.
    """
    value = node.stand_in.newest_value(name)
    if value is None:
        raise BadInput(
            f"{name} is neither planned nor has it arrived for {JUMP_S:g} s; plan it in channels, or ask again when it "
            "arrives"
        )
    return value


def _prediction(served: wire.ModelSnapshot, rate: Array, channels: Mapping[str, Array]) -> Prediction:
    """The model along a plan."""
    several = served.model.several
    if several is None:
        return served.model.predict(rate)
    return served.model.over(np.column_stack([rate, *(channels[name] for name in several.others)]))
