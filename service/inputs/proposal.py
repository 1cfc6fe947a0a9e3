"""A proposed mapping: what it is found from, and what is said of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from incsvr.plant.axes import YAW, Axis
from service.inputs.settings import Inputs, Source, Thrusters
from service.inputs.table import Topic
from service.inputs.vehicle_kind import SelfDescription


@dataclass(frozen=True, slots=True)
class Observation:
    """The topics and parameters that a preset chooses from.

    Attributes:
        topics: of the vehicle that is taken, with fields of theirs that are known.
        parameters: of the vehicle, by name, as far as it told them.
        self_description: what the vehicle says of itself beside.
        absent_batteries: topics of batteries that show no battery.
        ranks: how poor a candidate is by its values, by topic and field; 0 where it moves, or nobody looked.
        axis: whose velocity and effort are learned from.
    """

    topics: Sequence[Topic]
    parameters: Mapping[str, float] = field(default_factory=dict)
    self_description: SelfDescription = field(default_factory=SelfDescription)
    absent_batteries: frozenset[str] = frozenset()
    ranks: Mapping[tuple[str, str], int] = field(default_factory=dict)
    axis: Axis = YAW


@dataclass(frozen=True, slots=True)
class Change:
    """The thrusters from an instant on, because a parameter changed.

    Attributes:
        since: arrival of the parameter [s].
        thrusters: from then on; None where they are not known.
        parameters: what changed, each with its value and the value before, such as `MOT_1_DIRECTION -1 (+1 before)`.
    """

    since: float
    thrusters: Thrusters | None
    parameters: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Proposal:
    """A mapping that a preset found.

    Attributes:
        inputs: the mapping, as far as it goes; its preset is the one that found it.
        notes: what it was concluded from, one sentence each.
        reasons: what each quantity was concluded from, by its name, as long as nobody says where it stands.
        missing: what nothing was found for, by name: a sentence with the cure.
        unseen: those of the missing of which there is nothing at all, so that somebody has to say where they stand.
        changes: of the thrusters under way, in their order.
    """

    inputs: Inputs
    notes: tuple[str, ...] = ()
    missing: Mapping[str, str] = field(default_factory=dict)
    changes: tuple[Change, ...] = ()
    reasons: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    unseen: frozenset[str] = frozenset()

    @property
    def sentences(self) -> tuple[str, ...]:
        """The sentences on the sources of a proposal."""
        return (*self.notes, *(sentence for each in self.reasons.values() for sentence in each))

    def with_inputs(self, inputs: Inputs) -> Proposal:
        """The proposal with some inputs as somebody named them."""
        told = {name for name in ("yaw_rate", "torque", "thrusters") if getattr(inputs, name) is not None}
        over = {name: getattr(inputs, name) for name in told}
        if told & {"torque", "thrusters"}:
            over = {"torque": None, "thrusters": None} | over
        if inputs.armed is not None:
            over["armed"] = inputs.armed
        found = {"torque" if name == "thrusters" else name for name in told}
        changes = () if "torque" in found else self.changes
        battery = inputs.channels.get("voltage")
        if battery is not None and "torque" not in found:  # then the thrusters draw from that one, too
            over["thrusters"] = _drawing_from(self.inputs.thrusters, battery)
            changes = tuple(replace(each, thrusters=_drawing_from(each.thrusters, battery)) for each in changes)
        over["channels"] = {**self.inputs.channels, **inputs.channels}
        missing = {name: cure for name, cure in self.missing.items() if name not in found}
        return replace(
            self,
            inputs=self.inputs.model_copy(update=over),
            missing=missing,
            changes=changes,
            reasons={name: each for name, each in self.reasons.items() if name not in {*found, *inputs.channels}},
            unseen=self.unseen - found,
        )


def _drawing_from(thrusters: Thrusters | None, battery: Source) -> Thrusters | None:
    return None if thrusters is None else thrusters.model_copy(update={"measured_voltage": battery})


NOTHING_FOUND = {
    "yaw_rate": "no yaw rate was found; name it: --column yaw_rate=TOPIC.FIELD:deg/s",
    "torque": "no torque was found; name it: --column torque=TOPIC.FIELD, or describe the thrusters "
    "in the section inputs of a configuration (--config)",
}


def others_note(
    quantity: str, taken: str, others: Sequence[str], why: str, cure: str = "--column or inputs names another"
) -> tuple[str, ...]:
    """The sentence on the topic that is used of several; nothing if there is one."""
    if not others:
        return ()
    rest = f"{', '.join(others[:6])}{' …' if len(others) > 6 else ''}"
    return (f"{quantity} is taken from {taken} ({why}); {rest} {'is' if len(others) == 1 else 'are'} ignored: {cure}",)
