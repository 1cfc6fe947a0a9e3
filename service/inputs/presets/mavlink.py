"""MAVLink as it is on a link: telemetry logs, and the JSON of BlueOS's Zenoh router and recorder.

MAVLink's axes are north, east, down: yaw counts clockwise seen from above, and so does the moment that is made of
ArduSub's outputs.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from service.inputs import ardusub_frames, vehicle_kind
from service.inputs.outputs import BANK_OUTPUTS, output_numbers
from service.inputs.owners import AUTOPILOT, autopilot_message, base, numbered
from service.inputs.presets.proposal import Observation, Proposal, instances, others_note
from service.inputs.settings import Armed, Inputs, Source, StampedBy, Thrusters
from service.inputs.table import Topic

_MESSAGES = "ATTITUDE SERVO_OUTPUT_RAW HEARTBEAT VFR_HUD BATTERY_STATUS SYS_STATUS PARAM_VALUE"
KEYS = tuple(f"mavlink/*/{AUTOPILOT}/{message}" for message in _MESSAGES.split())
"""The keys that are listened to on a bus."""
ARMED_BIT = 128
"""The bit of a heartbeat's base mode that says that the autopilot is armed (MAV_MODE_FLAG_SAFETY_ARMED)."""
OUTPUT_MESSAGE = "SERVO_OUTPUT_RAW"
Place = Callable[[int], tuple[str, str]]
"""Topic and path of an output, by its number."""


def proposal(observed: Observation) -> Proposal | None:
    """The mapping of a vehicle that speaks MAVLink; None where there is no attitude of an autopilot."""
    said = _messages(observed)
    if "ATTITUDE" not in said:
        return None
    topic, path = said["ATTITUDE"]
    clock = StampedBy(stamp=f"{path}time_boot_ms", stamp_unit="ms")
    channels = {
        name: Source(topic=topic.name, field=f"{path}{field}", unit=unit, **clock)
        for name, field, unit in (
            ("heading", "yaw", "rad"),
            ("roll_rate", "rollspeed", "rad/s"),
            ("pitch_rate", "pitchspeed", "rad/s"),
        )
        if f"{path}{field}" in topic.fields
    }
    voltage, of_battery = _voltage(said, observed.absent_batteries)
    if voltage is not None:
        channels["voltage"] = voltage
    if "VFR_HUD" in said:
        hud, inside = said["VFR_HUD"]
        channels["depth"] = Source(topic=hud.name, field=f"{inside}alt", unit="m", sign=-1)
    thrusters, notes, missing = _thrusters(said, observed, voltage)
    inputs = Inputs(
        preset="blueos",
        yaw_rate=Source(topic=topic.name, field=f"{path}yawspeed", unit="rad/s", **clock),
        thrusters=thrusters,
        channels=channels,
        armed=heartbeat(said["HEARTBEAT"][0]) if "HEARTBEAT" in said else None,
    )
    return Proposal(inputs, missing=missing, reasons={"torque": notes, "voltage": of_battery})


def heartbeat(topic: Topic) -> Armed:
    """Armed by the autopilot's own heartbeat: a ground station's and a camera's have the same bit."""
    path = _inside(topic)
    bits = f"{path}base_mode.bits"
    return Armed(topic=topic.name, field=bits if bits in topic.fields else f"{path}base_mode", bit=ARMED_BIT)


def _messages(observed: Observation) -> dict[str, tuple[Topic, str]]:
    """The messages of the autopilot by name and instance: the topic, and where in a message the fields stand."""
    found = {}
    for topic in sorted(observed.topics, key=lambda each: each.count):  # the busiest stays
        message = autopilot_message(topic)
        if message is not None:
            found[message] = (topic, _inside(topic))
    return found


def _inside(topic: Topic) -> str:
    """The path before a message's fields: `message.` in JSON."""
    return "message." if any(name.startswith("message.") for name in topic.fields) else ""


def _voltage(said: dict[str, tuple[Topic, str]], absent: frozenset[str]) -> tuple[Source | None, tuple[str, ...]]:
    """The battery with the lowest number that shows a battery, and what is to be said of the others."""
    batteries = instances(said, "BATTERY_STATUS")
    alive = [name for name in batteries if said[name][0].name not in absent]
    for message, field in (*((name, "voltages[0]") for name in alive), ("SYS_STATUS", "voltage_battery")):
        if message in said and f"{said[message][1]}{field}" in said[message][0].fields:
            topic, path = said[message]
            others = [name for name in batteries if name != message]
            return Source(topic=topic.name, field=f"{path}{field}", unit="mV"), others_note("voltage", message, others)
    return None, ()


def _thrusters(
    said: dict[str, tuple[Topic, str]], observed: Observation, voltage: Source | None
) -> tuple[Thrusters | None, tuple[str, ...], dict[str, str]]:
    banks = instances(said, OUTPUT_MESSAGE)
    if not banks:
        asks = "no SERVO_OUTPUT_RAW was found: let the vehicle send it (SR*_RC_CHAN), or use the vehicle's own .BIN"
        return None, (), {"torque": asks}
    topic, path = said[banks[0]]
    whole = base(topic.name)
    kind, notes, missing = frame_of(observed, partial(_place, OUTPUT_MESSAGE, ""))
    if kind is None:
        return None, notes, missing
    driven = ardusub_frames.thrusters(observed.parameters, kind, partial(_place, whole, path))
    common, each = ardusub_frames.at_one_topic(driven)
    thrusters = Thrusters(
        topic=common,
        command="pwm",
        each=each,
        measured_voltage=voltage,
        stamp=f"{path}time_usec",
        stamp_unit="us",
    )
    used = list(dict.fromkeys(thrusters.topics))
    left = [name for name in banks if said[name][0].name not in used]
    taken = ", ".join(OUTPUT_MESSAGE + name.removeprefix(whole) for name in used)
    why = f"where outputs {', '.join(map(str, output_numbers(thrusters)))} are"
    return thrusters, (*notes, *others_note("torque", taken, left, why, "inputs.thrusters names another")), {}


def _place(topic: str, path: str, output: int) -> tuple[str, str]:
    bank, place = divmod(output - 1, BANK_OUTPUTS)
    return numbered(topic, bank), f"{path}servo{place + 1}_raw"


def frame_of(observed: Observation, place: Place) -> tuple[int | None, tuple[str, ...], dict[str, str]]:
    """The frame by the vehicle's own parameters, what is to be said of it, and what is missing where none is known.

    Args:
        place: topic and path of an output, as people write them in a configuration.
    """
    other = vehicle_kind.evidence_of_another_vehicle(observed.self_description, observed.parameters)
    if other is not None:
        cure = vehicle_kind.thruster_example(observed.parameters, place)
        return (
            None,
            (),
            {
                "torque": f"the thrusters' places and directions are unknown, because this is no "
                f"BlueROV2 ({other}): {cure}"
            },
        )
    kind = ardusub_frames.frame(observed.parameters)
    assumption = ardusub_frames.assumption(observed.parameters)
    assumed = () if assumption is None else (assumption,)
    if kind is None:
        return 1, assumed, {}
    if kind not in ardusub_frames.FRAME_NAMES:
        cure = f"the levers of frame {kind} are not known: {vehicle_kind.thruster_example(observed.parameters, place)}"
        return None, (), {"torque": cure}
    names = [f"MOT_{motor}_DIRECTION" for motor in range(1, len(ardusub_frames.YAW_SHARES) + 1)]
    told = [f"{observed.parameters[name]:+.0f}" for name in names if name in observed.parameters]
    directions = f", directions {', '.join(told)}" if told else ""
    by = f"frame {kind} ({ardusub_frames.FRAME_NAMES[kind]}){directions}, by the vehicle's parameters"
    return kind, (by, *assumed), {}
