"""A dive as a BlueROV2 Heavy tells it: pymavlink packs each message, BlueOS's server writes it as JSON on its keys."""

from __future__ import annotations

import json
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as dialect

from tests.service.logs.dive import BOOT, PARAMETERS, VOLTS, Dive

ARMED, DISARMED = 209, 81
_LINK = dialect.MAVLink(None)


def wire(message: Any) -> dict[str, Any]:
    """The fields as they are after a link: packed, and decoded again."""
    packed = message.pack(_LINK)
    return dict(dialect.MAVLink(None).decode(bytearray(packed)).to_dict())


def put(message: Any, system: int = 1, component: int = 1, **over: Any) -> tuple[str, bytes]:
    """Key and payload as the server has them; `over` says fields that JSON has in another form."""
    fields = wire(message)
    kind = fields.pop("mavpackettype")
    if "type" in fields:
        fields["mavtype"] = fields.pop("type")
    header = {"system_id": system, "component_id": component, "sequence": 17, "message_id": message.get_msgId()}
    said = {"header": header, "message": {"type": kind, **fields, **over}}
    return f"mavlink/{system}/{component}/{kind}", json.dumps(said).encode()


def heartbeat(mode: Any, component: int = 1, system: int = 1) -> tuple[str, bytes]:
    bits = mode if isinstance(mode, int) else 0
    message = dialect.MAVLink_heartbeat_message(12, 3, bits, 0, 4, 3)
    return put(message, system, component, base_mode={"bits": mode} if isinstance(mode, int) else mode)


def parameter(name: str, value: float) -> tuple[str, bytes]:
    message = dialect.MAVLink_param_value_message(name.encode(), value, 9, 900, 1)
    return put(message, param_id=[*name, *["\0"] * (16 - len(name))])


def parameters() -> list[tuple[str, bytes]]:
    return [parameter(name, value) for name, value in PARAMETERS.items()]


def attitude(t: float, rate: float, yaw: float = 0.0) -> tuple[str, bytes]:
    return put(dialect.MAVLink_attitude_message(round(1000 * (BOOT + t)), 0.0, 0.0, yaw, 0.0, 0.0, rate))


def outputs(t: float, pulses: Any) -> tuple[str, bytes]:
    told = [int(pulse) for pulse in pulses] + [1500] * 4
    return put(dialect.MAVLink_servo_output_raw_message(round(1e6 * (BOOT + t)) % 2**32, 0, *told))


def battery(volts: float = VOLTS) -> tuple[str, bytes]:
    cells = [round(1000 * volts), *[65535] * 9]
    return put(dialect.MAVLink_battery_status_message(0, 0, 1, 2000, cells, 100, 5, 5, 90))


def stream(dive: Dive, first: float = 0.0, last: float = 1e9, mode: Any = ARMED) -> list[tuple[str, bytes]]:
    """What is on the bus between two times [s], the ground station's and the companion's heartbeats, too."""
    found = []
    for t, rate, pulses in zip(dive.time, dive.rate, dive.pulses, strict=True):
        if not first <= t < last:
            continue
        if t == int(t):
            found += [heartbeat(mode), heartbeat(192, 190, 255), heartbeat(128, 194), battery()]
        found += [attitude(t, rate), outputs(t, pulses)]
    return found
