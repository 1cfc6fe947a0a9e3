"""The sentences of health about what was rejected and how the vehicle moves: from what is known, no state, no clock."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from incsvr.learning.excitation import EXCITING_MANOEUVRE
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, stream_of
from incsvr.plant.axis_words import in_words_of
from incsvr.plant.body import Coupled
from incsvr.plant.words import AxisWords
from service.health.stream_monitor import StreamMonitor
from service.learner.node import LearnerNode

CURES = {
    frozenset({"not_json", "wrong_form", "wrong_type", "unequal_length", "name_twice"}): (
        'a measurement is {{"t": 12.34, "value": 0.083}}, or {{"t": [12.34, 12.36], "value": [0.083, 0.081]}}, as JSON'
    ),
    frozenset({"implausible"}): (
        "a {rate} beyond vehicle.rate_limit or a {effort} beyond vehicle.torque_limit counts as a sensor's fault"
    ),
    frozenset({"wrong_encoding"}): "a measurement has the encoding application/json",
}
"""The cures for refused messages, by the reasons: templates of `AxisWords`."""


def taken_for_zero(coupled: Coupled) -> tuple[str, ...]:
    """The sentence on velocities that the mass matrix needs and no source publishes."""
    if not coupled.missing:
        return ()
    unknown = ", ".join(f"channel {stream_of(coupled.axis, name)}" for name in coupled.missing)
    return (
        f"assumed zero in the mass matrix's terms, because it is not published: {unknown}; publish it and list it in "
        "signals.channels, or run a learner of that axis in this process",
    )


def rejection_sentences(lately: dict[str, int], words: AxisWords) -> list[str]:
    """The sentences on rejected messages, from reason → count, with the cures."""
    told = []
    if lately.pop("clock_restarted", 0):
        told.append(f"the clocks of {words.rate} and {words.effort} restarted")
    for reason, count in lately.items():
        told.append(f"{count} {'value' if count == 1 else 'values'} rejected: {reason.replace('_', ' ')}")
    return told + [words.fill(cure) for reasons, cure in CURES.items() if lately.keys() & reasons]


def stillness_sentences(rate: StreamMonitor, longest: float, words: AxisWords) -> list[str]:
    """The yaw rate has been the same for longer than that [s]."""
    if rate.still_since is not None and rate.t is not None:
        still = rate.t - rate.still_since
        if still > longest:
            return [f"the {words.rate} is constant at {rate.value:g} {words.rate_unit} for {still:.1f} s"]
    return []


def motion_sentences(node: LearnerNode) -> list[str]:
    """The sentences on motion that is too fast for the streams, or excites too little."""
    told, recent, axis = [], node.recent_batches, AXES[node.config.vehicle.axis]
    quick, excitation = recent.unresolved, recent.excitation
    if quick is not None:
        told.append(in_words_of(axis, f"{quick.sentence}; {quick.cure(node.config.signal_settings())}"))
    if excitation is not None and excitation.little and recent.without_evidence_since is None:
        told.append(f"little excitation: {evidence_sentence(node)}")
    return told


def evidence_sentence(node: LearnerNode) -> str | None:
    """The sentence on the share of recent motion that is evidence, with the manoeuvre; None before the first batch."""
    excitation = node.recent_batches.excitation
    if excitation is None:
        return None
    return in_words_of(AXES[node.config.vehicle.axis], f"{excitation.sentence}; {EXCITING_MANOEUVRE}")


MAX_BEYOND_PART = 0.1
"""The part of its width by which the learned range may be left untold: noise and reversals at its ends reach
0.06 in the paper's experiment, a motion that was never learned 0.2 and more."""


def extrapolation_sentence(node: LearnerNode) -> str | None:
    """Most of the newest samples are where the model only extrapolates."""
    served, newest, words = node.served.model, node.batches.newest, node.words
    several = served.several is not None
    rates = newest.yaw_rate if several else np.array(node.batches.recent_rates)
    if not rates.size or not served.is_trained:
        return None
    low, high = served.trained_range or (0.0, 0.0)

    def within(rate: Array) -> Array:
        """The rates, and those that are hardly beyond an end as if they were at it."""
        inside = np.clip(rate, low, high)
        return np.where(np.abs(rate - inside) <= MAX_BEYOND_PART * (high - low), inside, rate)

    said = served.at(replace(newest, yaw_rate=within(newest.yaw_rate))) if several else served.predict(within(rates))
    beyond = rates[said.extrapolated]
    if 2 * beyond.size <= rates.size:
        return None
    return (
        f"the vehicle {words.turns} at {beyond[-1]:.3g} {words.rate_unit}, where the model extrapolates "
        f"(learned {low:.3g} to {high:.3g} {words.rate_unit}{', among other velocities' if several else ''})"
    )
