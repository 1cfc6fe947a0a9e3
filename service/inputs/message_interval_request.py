"""Asking a vehicle for more: MAVLink's SET_MESSAGE_INTERVAL, by BlueOS's server, which sends on what it gets as JSON.

This is the only thing that is ever written to a vehicle, and a person asks for it. It lasts until the autopilot starts
anew.
"""

from __future__ import annotations

import json

from service.wire.json_text import json_text

REQUEST_KEY = "mavlink/in"
"""The key at which BlueOS's MAVLink server takes messages (bluerobotics/mavlink-server, drivers/zenoh)."""
ACK_MESSAGE = "COMMAND_ACK"
SET_MESSAGE_INTERVAL = 511
REQUESTED_MESSAGES = {"ATTITUDE": 30, "SERVO_OUTPUT_RAW": 36}
"""The messages that are learned from, by their numbers."""
STATION_SYSTEM, COMPUTER_COMPONENT = 255, 191
"""The sender of a request: the system of ground stations, from which ArduPilot takes commands, and an onboard
computer."""


def request(system: int, message: int, hertz: float) -> bytes:
    """The payload that asks the autopilot of a system for a message so often a second."""
    parameters = [float(message), round(1e6 / hertz), 0.0, 0.0, 0.0, 0.0, 0.0]
    said = {
        "header": {"system_id": STATION_SYSTEM, "component_id": COMPUTER_COMPONENT, "sequence": 0},
        "message": {
            "type": "COMMAND_LONG",
            **{f"param{k}": float(value) for k, value in enumerate(parameters, start=1)},
            "command": {"type": "MAV_CMD_SET_MESSAGE_INTERVAL"},
            "target_system": system,
            "target_component": 1,
            "confirmation": 0,
        },
    }
    return json_text(said).encode()


def is_accepted(payload: bytes) -> bool | None:
    """Whether an acknowledgement says that the interval was set; None where it is of something else."""
    try:
        message = json.loads(payload)["message"]
        command, result = message["command"], message["result"]
    except (ValueError, KeyError, TypeError):
        return None
    command = command.get("type") if isinstance(command, dict) else command
    if command not in ("MAV_CMD_SET_MESSAGE_INTERVAL", SET_MESSAGE_INTERVAL):
        return None
    result = result.get("type") if isinstance(result, dict) else result
    return result in ("MAV_RESULT_ACCEPTED", 0)
