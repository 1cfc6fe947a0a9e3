"""What is said of thrust that is lost, or back: on a key of its own once, and on health while it lasts."""

from __future__ import annotations

from incsvr.checks.verdict import CHANGE_MEMORY_S
from incsvr.errors import BadInput
from incsvr.forecasting.thrust_watch import NORMAL_95_DEVIATIONS, ThrustChange
from incsvr.plant.mass_and_coriolis import inertia_in_force
from incsvr.plant.words import AxisWords
from service import wire
from service.learner.node import LearnerNode
from service.state.history import History


def thrust_event(node: LearnerNode, history: History, change: ThrustChange) -> wire.ThrustEvent:
    """A change of the thrust as it is published."""
    level, doubt = change.level
    half = NORMAL_95_DEVIATIONS * doubt
    try:
        revision = history.at(change.since).revision
    except BadInput:
        revision = None
    return wire.ThrustEvent(
        boot=node.boot,
        event="thrust back" if change.is_back else "thrust lost",
        axis=node.words.name,
        since=change.since,
        t=change.seen,
        size=1.0 - level,
        size_low=1.0 - level - half,
        size_high=1.0 - level + half,
        thrust=level,
        inertia=inertia_in_force(node.config.vehicle.inertia, node.served.effects),
        revision=revision,
        cannot_tell_from=change.cannot_tell_from,
        why=sentence(change, node.words),
    )


def sentence(change: ThrustChange, words: AxisWords) -> str:
    """A change of the thrust for people."""
    level, doubt = change.level
    half = NORMAL_95_DEVIATIONS * doubt
    within = f"{100.0 * level:.0f} % (± {100.0 * half:.0f} %)"
    if change.is_back:
        return f"since {change.since:.1f} s the {words.name} thrust is back: {within} of the usual {words.effort} acts"
    return (
        f"since {change.since:.1f} s {words.name} thrust is lost: {within} of the commanded {words.effort} acts; "
        "look at the thrusters for a rope, a fault of a drive or an empty battery"
    )


def thrust_notice(node: LearnerNode, change: ThrustChange | None) -> tuple[str, ...]:
    """What health says of the last change: while thrust is lost, and for some minutes after it is back.

    Args:
        node: the learner.
        change: the last change since the start; None where there is none.
    """
    if change is not None and not change.is_back:
        return (sentence(change, node.words),)
    if change is not None:
        newest = node.served.t
        return (sentence(change, node.words),) if newest is None or newest - change.seen < CHANGE_MEMORY_S else ()
    lost = 0.0 if node.thrust is None else 1.0 - node.thrust.state.level
    if lost <= 0.0:
        return ()
    return (f"before the restart {100.0 * lost:.0f} % of the {node.words.name} thrust was lost",)


def pause_words(paused: str | None, change: ThrustChange | None) -> str | None:
    """Why learning is paused, with the thrust that is lost meanwhile: the checks of the sensors do not know of it."""
    if paused is None or change is None or change.is_back:
        return paused
    return f"{paused}; the thrust that is lost may be the cause"
