"""Opening Zenoh: loopback by default, never all interfaces, never multicast.

The learner listens and everybody else is its client, so no router is needed; where the vehicle already runs one, the
learner is one more client of it. A Zenoh JSON5 file (TLS, access control) replaces all of this and is passed untouched.
"""

from __future__ import annotations

import copy
import json
import logging
import math
import signal
import socket
import threading
import time
import uuid
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import zenoh
from zenoh.handlers import RingChannel

from incsvr.errors import BadInput
from service import wire
from service.wire.form import FormType, decode
from service.wire.json_text import json_text

if TYPE_CHECKING:
    from service.config.sections import Bus
    from service.security.certificate_validity import Validity


_FILES = (
    "root_ca_certificate",
    "listen_certificate",
    "listen_private_key",
    "connect_certificate",
    "connect_private_key",
)


def section(config: zenoh.Config, name: str) -> Any:
    """A part of it, such as access_control; None where it is not given."""
    return json.loads(config.get_json(name))


def endpoints(config: zenoh.Config, side: Literal["listen", "connect"]) -> list[str]:
    """The endpoints to listen at or to connect to; a file may give them for each mode."""
    found = section(config, f"{side}/endpoints") or []
    return [endpoint for part in found.values() for endpoint in part] if isinstance(found, dict) else list(found)


def tls_section(config: zenoh.Config) -> Mapping[str, Any]:
    """The TLS section of the file; empty if there is none."""
    found = section(config, "transport/link/tls") or {}
    return {name: value for name, value in found.items() if value is not None}


def tls_files(config: zenoh.Config) -> dict[str, Path]:
    """The certificates and keys that it names."""
    tls = tls_section(config)
    return {name: Path(tls[name]) for name in _FILES if name in tls}


log = logging.getLogger(__name__)

_COMMON_SETTINGS: dict[str, Any] = {
    # Nothing is scouted for, so waiting half a second for answers would only delay the start.
    "scouting": {"delay": 0, "multicast": {"enabled": False}, "gossip": {"enabled": False}},
    "timestamping": {"enabled": True},
    # A hung process is noticed after two seconds, not ten. Shared memory would only add a way to fail.
    "transport": {"link": {"tx": {"lease": 2000}}, "shared_memory": {"enabled": False}},
}
_RELAY_SETTINGS: dict[str, Any] = {
    # Whoever asks and does not read is cut off after this time [µs]: Zenoh holds its tables while a message waits for
    # room, so that for all others the bus stands still so long. Sixteen batches of 64 kB are more than one answer
    # (`service.host.answers`), so that a slow link that reads on is never cut off.
    "tx": {
        "lease": 2000,
        "queue": {"size": {"data": 16}, "congestion_control": {"block": {"wait_before_close": 500_000}}},
    },
    # What is larger [bytes] is dropped by Zenoh while it arrives; the learner counts what is smaller and too large.
    "rx": {"max_message_size": 16_000_000},
}
LOOK_PERIOD_S = 10.0
"""The time after which whoever waits for a bus looks again why it cannot be met [s]."""
CLOSING_TIMEOUT_S = 1.0
"""The time that an end may take [s]; Zenoh itself waits ten for a client that does not read."""


def stop_event() -> threading.Event:
    """An event that SIGTERM and Ctrl-C set; only the main thread may ask for it.

    It is set by a thread of its own: a signal may come while the main thread's wait has the event locked. And whoever
    waits for it in the main thread does so for a while, again and again: Python runs handlers between two steps of that
    thread, and a signal just before a wait without end would never be heard.
    """
    stop = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: threading.Thread(target=stop.set).start())
    return stop


def listener_settings(endpoint: str) -> dict[str, Any]:
    """Zenoh's settings of a learner that listens at `endpoint` and relays between its clients."""
    transport = _COMMON_SETTINGS["transport"] | {"link": _RELAY_SETTINGS}
    return copy.deepcopy(
        _COMMON_SETTINGS | {"transport": transport, "mode": "router", "listen": {"endpoints": [endpoint]}}
    )


def client_settings(endpoint: str) -> dict[str, Any]:
    """Zenoh's settings of a client of the learner, or of an existing router, at `endpoint`.

    It reconnects within half a second after the listener was killed; Zenoh's own retry takes four.
    """
    connect = {
        "endpoints": [endpoint],
        "timeout_ms": 0,  # `open_session` waits, so that waiting can be interrupted
        "exit_on_failure": True,
        "retry": {"period_init_ms": 200, "period_max_ms": 500, "period_increase_factor": 1.5},
    }
    return copy.deepcopy(_COMMON_SETTINGS) | {"mode": "client", "connect": connect}


def listener_config_at(endpoint: str) -> zenoh.Config:
    """The configuration of a learner that listens at `endpoint`."""
    return zenoh.Config.from_json5(json_text(listener_settings(endpoint)))


def client_config_at(endpoint: str) -> zenoh.Config:
    """The configuration of a client at `endpoint`."""
    return zenoh.Config.from_json5(json_text(client_settings(endpoint)))


def from_file(path: Path) -> zenoh.Config:
    """A Zenoh JSON5 file as it is."""
    try:
        return zenoh.Config.from_file(str(path))
    except zenoh.ZError as error:
        raise BadInput(f"{path} is no Zenoh configuration: {_first_line(error)}") from error


def client_config(bus: Bus) -> zenoh.Config:
    """The configuration of a client of a learner's bus."""
    return client_config_at(bus.connect or bus.listen) if bus.zenoh_file is None else from_file(bus.zenoh_file)


def client_place(bus: Bus) -> str:
    """The endpoint of a client's bus, in words."""
    return bus.connect or bus.listen if bus.zenoh_file is None else f"the endpoint of {bus.zenoh_file}"


def open_session(config: zenoh.Config, patience_s: float = 0.0, stop: threading.Event | None = None) -> zenoh.Session:
    """Opens a session; use it in a `with`, or the interpreter can hang at exit.

    Args:
        patience_s: how long to try again where nobody listens yet [s]; infinity waits for ever.
        stop: ends the waiting.

    Raises:
        BusRefusal: the endpoint is taken, or our certificate is not valid now; at once where the patience has an end.
        BadInput: nobody listens there.
    """
    zenoh.init_log_from_env_or("error")
    until = time.monotonic() + patience_s
    stop = stop or threading.Event()
    said, look = "", 0.0
    while True:
        try:
            session = zenoh.open(config)
        except zenoh.ZError as error:
            over = time.monotonic() >= until or stop.wait(0.2)
            if not over and time.monotonic() < look:
                continue
            problem = BadInput(_first_line(error)) if stop.is_set() else _problem(config, error)
            if over or (isinstance(problem, BusRefusal) and math.isfinite(patience_s)):
                raise type(problem)(f"the bus cannot be opened: {problem}") from error
            if str(problem) != said:
                level = logging.WARNING if isinstance(problem, BusRefusal) else logging.INFO
                log.log(level, "waiting for the bus: %s", problem)
            said, look = str(problem), time.monotonic() + LOOK_PERIOD_S
        else:
            for each in certificates(config):
                if (sentence := each.sentence_now()) is not None:
                    log.warning("%s", sentence)
            return session


class BusRefusal(BadInput):
    """The endpoint is in use, but no session can be opened."""


def nobody_at(bus: Bus) -> str:
    """The message of a client that finds no bus, with the cure."""
    cure = "start `incsvr serve`, or give its endpoint with --connect"
    if bus.zenoh_file is not None:
        cure = (
            "start `incsvr serve`; if it runs, use the files that `incsvr keys` made with its own, at the endpoint "
            "that they name, and compare clocks and ends of the certificates on both machines (`incsvr config check`)"
        )
    return f"no bus answers at {client_place(bus)}: {cure}"


def certificates(config: zenoh.Config) -> tuple[Validity, ...]:
    """The validity of a configuration's certificates; none without TLS."""
    tls = tls_section(config)
    if not tls:
        return ()
    # Loaded where it is needed alone: most buses have none.
    from service.security.certificate_validity import validities

    return validities(tls)


def _problem(config: zenoh.Config, error: zenoh.ZError) -> BadInput:
    """The error that explains why no session was opened: `BusRefusal` if the endpoint is in use."""
    tls = bool(tls_section(config))
    if "address already in use" in str(error).lower():
        endpoint = next(iter(endpoints(config, "listen")), "the endpoint")
        cure = f"listen at another port with --listen, or be its client with --connect {endpoint}"
        if tls:
            cure = "or make keys for another port (`incsvr keys --listen`)"
        return BusRefusal(
            f"{endpoint} is in use, by another learner, a router or another program (`incsvr status` shows a learner, "
            f"`ss -ltnp` any program); end it, {cure}"
        )
    refused = [each.sentence_now() for each in certificates(config) if each.refused_now]
    if refused and refused[0] is not None:
        return BusRefusal(refused[0])
    return BadInput(_first_line(error))


def answer(session: zenoh.Session, selector: str, form: type[FormType], timeout_s: float = 2.0) -> FormType | None:
    """The first answer to a question that is asked once; None where nobody answers in time, or refuses.

    Raises:
        BadInput: what answers is no such form.
    """
    for reply in session.get(selector, timeout=timeout_s):
        if reply.ok is not None:
            return decode(form, reply.ok.payload.to_bytes())
    return None


def finish_in_time(work: Callable[[], object]) -> None:
    """Ends a session or a part of it; a client that does not read holds that up for CLOSING_TIMEOUT_S at most."""
    closing = threading.Thread(target=work, daemon=True)
    closing.start()
    closing.join(CLOSING_TIMEOUT_S)


def _first_line(error: Exception) -> str:
    """Zenoh's message without its brackets and the places in its own source."""
    message = str(error).partition(" at /")[0].partition("\n")[0].strip()
    return message.replace("any of [Single(", "").replace(")]!", "")


def free_endpoint() -> str:
    """A loopback endpoint that nobody uses now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


DEAD_TOKEN_S = 3.0
"""The time for which the token of a learner that died is seen [s]: a lease of two seconds, and one of grace."""
HEALTH_MEMORY_S = 5.0
"""The time for which another learner counts as there after its last health [s]; it comes once a second."""
START_WAIT_S = 0.5
"""The time for which a client of a hub waits for others that start in the same moment [s]; their tokens are seen in
milliseconds, over a slow link in tenths of a second."""
CANDIDATE_MARK, OWNER_MARK = "1", "0"
"""The first letter of a name on `…/coming/*`: who stays comes before all who are coming."""


def take_prefix(session: zenoh.Session, prefix: str, stop: threading.Event, hub: bool) -> Any:
    """Waits until nobody else is alive under this prefix, and returns a token that is to be held as long as we are.

    Of several that start in the same moment, each has said so before it looks, and looks for START_WAIT_S: so all
    see each other, and the one with the smallest name stays.

    Args:
        hub: other learners may be clients of the same hub; who listens itself has its port alone.

    Raises:
        BadInput: somebody else stays.
    """
    keys, name = wire.Keys(prefix), uuid.uuid4().hex
    liveliness = session.liveliness()
    coming: Any = liveliness.declare_token(keys.coming(CANDIDATE_MARK + name))
    began = time.monotonic()
    while (taken := _is_taken(session, keys, name)) or (hub and time.monotonic() < began + START_WAIT_S):
        if taken and time.monotonic() >= began + DEAD_TOKEN_S:
            coming.undeclare()
            raise BadInput(
                f"another learner has the prefix {prefix} on this bus; end it, give this one another --prefix, or "
                "set bus.allow_second to run both"
            )
        if stop.wait(0.1):
            break
    token = liveliness.declare_token(keys.coming(OWNER_MARK + name))
    coming.undeclare()
    return token


def _is_taken(session: zenoh.Session, keys: wire.Keys, name: str) -> bool:
    """Whether a learner is alive, or one that comes is to stay rather than we."""
    if any(reply.ok is not None for reply in session.liveliness().get(keys.alive, timeout=DEAD_TOKEN_S)):
        return True
    replies = session.liveliness().get(keys.coming("*"), timeout=DEAD_TOKEN_S)
    names = {str(reply.ok.key_expr).rpartition("/")[2] for reply in replies if reply.ok is not None}
    return any(other < CANDIDATE_MARK + name for other in names)


class DuplicateLearner:
    """Listens whether somebody else publishes health under our prefix.

    Args:
        boot: identifies this start of ours.
        clock: a monotonic clock [s].
    """

    def __init__(self, session: zenoh.Session, keys: wire.Keys, boot: str, clock: Callable[[], float]) -> None:
        self._boot, self._clock = boot, clock
        self._ring: Any = session.declare_subscriber(keys.health, RingChannel(8), allowed_origin=zenoh.Locality.REMOTE)
        self._last_other: tuple[str, float] | None = None

    def notice(self) -> tuple[str, ...]:
        """The sentence of health on another learner of the same prefix; nothing without one."""
        while (sample := self._ring.try_recv()) is not None:
            try:
                other = wire.decode(wire.Health, sample.payload.to_bytes()).boot
            except BadInput:
                continue
            if other != self._boot:
                self._last_other = (other[:40], self._clock())
        if self._last_other is None or self._clock() - self._last_other[1] > HEALTH_MEMORY_S:
            return ()
        return (f"another learner, of boot {self._last_other[0]}, publishes under the same prefix; end one of them",)

    def close(self) -> None:
        self._ring.undeclare()
