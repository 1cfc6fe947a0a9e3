"""`incsvr inspect --bus`: listens to the vehicle's bus; of each input what came, how often, and whether it can be true.

Exit status 0 where yaw rate and torque came and nothing is missing, 1 else. With `--ask HZ` the vehicle is asked before
for its attitude and its outputs so often; nothing else ever writes to it.
"""

from __future__ import annotations

import argparse
import json
import threading
import time
from typing import Any

import zenoh

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES
from service.bus.mapped_ingest import Arrivals, mapping
from service.bus.session import client_config_at, from_file, listener_config_at, open_session
from service.cli.display import stream_unit
from service.cli.output import WIDTH, emit, shortened, wrapped
from service.config.configuration import Config
from service.config.sources import from_arguments
from service.inputs.input_mapper import InputMapper
from service.inputs.live_clock import RATE
from service.inputs.mapper import TORQUE
from service.inputs.owners import AUTOPILOT, mavlink
from service.inputs.survey import Survey
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


POLL_S = 0.05
"""The period at which arrived messages are read [s]."""
VEHICLE_TIMEOUT_S = 3.0
"""The longest wait for the vehicle that is asked, and for its answers [s]."""
MAX_ASK_HZ = 400.0
"""Faster no autopilot runs."""


def inspect_bus(args: argparse.Namespace) -> int:
    """Prints what arrives; the exit status."""
    config = from_arguments(args)
    if not 0.0 < args.seconds <= 3600.0:
        raise BadInput(f"--seconds {args.seconds:g}: give more than 0 s, and an hour at most")
    if args.ask is not None and config.inputs.preset != "blueos":
        raise BadInput("--ask: only a vehicle with BlueOS can be asked; add --set inputs.preset=blueos")
    if args.ask is not None and not 0.0 < args.ask <= MAX_ASK_HZ:
        raise BadInput(f"--ask {args.ask:g}: give messages a second, above 0 and at most {MAX_ASK_HZ:g}")
    hearing = InputMapper(mapping(config))
    vehicle = config.vehicle
    survey = Survey(hearing, {RATE: vehicle.rate_limit, TORQUE: vehicle.torque_limit})
    asked: dict[str, Any] = {}
    with _met(config, args.wait) as session:
        arrivals = Arrivals(session, hearing, lambda reason, count: hearing.refused.update({reason: count}))
        if args.ask is not None:
            asked = {"asked": _ask(session, hearing, arrivals, args.ask)}
        _listen(survey, arrivals, args.seconds)
        arrivals.close()
    result = {"seconds": args.seconds, **asked, **survey.summary()}
    emit(args, result, text(config, result))
    whole = {RATE, TORQUE} <= result["inputs"].keys() and not result["missing"]
    return 0 if whole else 1


def text(config: Config, result: dict[str, Any]) -> str:
    """The result for people, in 80 columns."""
    came = result["inputs"]
    where = config.bus.connect or config.bus.zenoh_file or config.bus.listen
    lines = [f"{where}, {result['seconds']:g} s" + (f", preset {config.inputs.preset}" if config.inputs.preset else "")]
    lines += ["", f"{'input':<13} {'values':>6} {'Hz':>5} {'lowest':>9} {'highest':>9}"]
    for name in sorted(came, key=lambda each: (each != RATE, each != TORQUE, each)):
        lines.append(_line(name, came[name], stream_unit(name, AXES[config.vehicle.axis])))
        lines += wrapped("    doubt: ", came[name]["doubts"])
    lines += [f"{name:<13} {'0':>6}" for name in (RATE, TORQUE) if name not in came]
    armed = {True: "armed", False: "not armed: nothing would be learned now", None: "unknown"}
    by = f" (by {result['armed_by']})" if result["armed_by"] else ""
    lines += ["", f"armed: {armed[result['armed']]}{by}"]
    if "asked" in result:
        lines += wrapped("asked: ", [f"{name}: {said}" for name, said in result["asked"].items()])
    lines += wrapped("missing: ", result["missing"].values())
    lines += wrapped("note: ", result["notices"])
    lines += wrapped(
        "refused: ", [f"{count} {reason.replace('_', ' ')}" for reason, count in result["refused"].items()]
    )
    used = {key for each in came.values() for key in each["keys"]} | {result["armed_by"]}
    others = [f"{key} ({each['rate_hz']:.3g} Hz)" for key, each in result["heard"].items() if key not in used]
    return "\n".join(lines + wrapped("received as well: ", [", ".join(others)] if others else []))


def _line(name: str, came: dict[str, Any], unit: str) -> str:
    low, high = ("-" if came[end] is None else f"{came[end]:.4g}" for end in ("low", "high"))
    where = ", ".join(came["keys"]) + (" (by arrival)" if came["stamps"] == "arrival" else "")
    line = f"{name:<13} {came['count']:>6} {came['rate_hz']:>5.3g} {low:>9} {high:>9} {unit:<5}"
    return f"{line} {shortened(where, WIDTH - len(line) - 1)}".rstrip()


def _met(config: Config, patience_s: float) -> zenoh.Session:
    """The vehicle's bus: as a client; where the learner would listen itself and does not run, in its place."""
    bus = config.bus
    if bus.zenoh_file is not None:
        return open_session(from_file(bus.zenoh_file), patience_s)
    if bus.connect is not None:
        try:
            return open_session(client_config_at(bus.connect), patience_s)
        except BadInput as error:
            raise BadInput(f"{error}; give the endpoint of the vehicle's router with --connect") from None
    try:
        return open_session(client_config_at(bus.listen))
    except BadInput:
        return open_session(listener_config_at(bus.listen))


def _listen(survey: Survey, arrivals: Arrivals, seconds: float) -> None:
    pause, until = threading.Event(), time.monotonic() + seconds
    while True:
        survey.take(arrivals.take())
        left = until - time.monotonic()
        if left <= 0.0:
            return
        pause.wait(min(POLL_S, left))


def _ask(session: zenoh.Session, hearing: InputMapper, arrivals: Arrivals, hertz: float) -> dict[str, str]:
    """Asks for the messages that are learned from; what the vehicle says to each.

    Raises:
        BadInput: there is no vehicle to ask.
    """
    system = _vehicle(hearing, arrivals)
    answers: list[bytes] = []
    key = f"mavlink/{system}/{AUTOPILOT}/{ACK_MESSAGE}"
    listener = session.declare_subscriber(key, lambda sample: answers.append(sample.payload.to_bytes()))
    said = {}
    for name, number in REQUESTED_MESSAGES.items():
        session.put(
            REQUEST_KEY,
            request(int(system), number, hertz),
            encoding="application/json",
        )
        said[name] = _answer(answers)
    listener.undeclare()  # type: ignore[no-untyped-call]
    return said


def _vehicle(hearing: InputMapper, arrivals: Arrivals) -> str:
    """The number of the first vehicle that is heard."""
    pause, until = threading.Event(), time.monotonic() + VEHICLE_TIMEOUT_S
    while time.monotonic() < until:
        hearing.take(arrivals.take())
        named = (mavlink(key) for key in hearing.bindings)
        system = hearing.system or next((found.system for found in named if found is not None), "")
        if system:
            return system
        pause.wait(POLL_S)
    raise BadInput("--ask: no vehicle sends on mavlink/…; switch on the Zenoh endpoint of BlueOS's MAVLink server")


def _answer(answers: list[bytes]) -> str:
    """The autopilot's answer, which is removed from the list of answers."""
    pause, until = threading.Event(), time.monotonic() + VEHICLE_TIMEOUT_S
    while time.monotonic() < until:
        while answers:
            accepted = is_accepted(answers.pop(0))
            if accepted is not None:
                return "accepted" if accepted else "refused"
        pause.wait(POLL_S)
    return "no answer"
