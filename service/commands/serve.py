"""`incsvr serve`: the learner on the bus, until SIGTERM or Ctrl-C."""

from __future__ import annotations

import argparse
import ctypes
import gc
import logging
import os
import socket
import sys
import threading
from pathlib import Path

from incsvr.errors import BadInput
from service.bus.session import (
    client_config_at,
    finish_in_time,
    from_file,
    listener_config_at,
    open_session,
    stop_event,
    take_prefix,
)
from service.config.configuration import Config, check_inertia
from service.config.sources import add_config_arguments, from_arguments
from service.host.host import Host
from service.host.worker_threads import WorkerThreads
from service.wire import Keys
from service.wire.json_text import json_text

READY, ALIVE, STOPPING = "READY=1", "WATCHDOG=1", "STOPPING=1"

STROKES_PER_TIMEOUT = 3
"""Strokes within the watchdog's time: one that comes late does not end the process."""


def tell_systemd(state: str) -> None:
    """Sends one state to $NOTIFY_SOCKET (sd_notify(3)), a path or, with a leading @, a name in the abstract namespace.

    Where systemd did not start us nothing is sent. What cannot be sent must not end the learning: systemd acts on
    silence.
    """
    address = os.environ.get("NOTIFY_SOCKET", "")
    if not address:
        return
    if address.startswith("@"):
        address = "\0" + address[1:]
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as channel:
            channel.setblocking(False)
            channel.sendto(state.encode(), address)
    except OSError as error:
        log.warning("systemd could not be notified of %s: %s", state, error)


def stroke_period() -> float | None:
    """The period of the watchdog's notification [s]; None without a watchdog."""
    watched = os.environ.get("WATCHDOG_PID", str(os.getpid()))
    microseconds = os.environ.get("WATCHDOG_USEC", "")
    if watched != str(os.getpid()) or not microseconds.isdecimal() or int(microseconds) == 0:
        return None
    return int(microseconds) / 1e6 / STROKES_PER_TIMEOUT


log = logging.getLogger(__name__)

THREAD_SWITCH_S = 0.0002
"""A thread that computes hands over to one that answers after this time [s]; Python's own is 5 ms."""

SIGNAL_WAIT_S = 1.0
"""Longest time in which a signal may go unheard [s]."""

_ARENA_MAX, _TRIM_THRESHOLD = -8, -1  # of mallopt(3)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_config_arguments(parser)
    parser.add_argument("--listen", metavar="ENDPOINT", help="endpoint to listen at, such as tcp/127.0.0.1:7447")
    parser.add_argument(
        "--vehicle",
        metavar="FILE",
        type=Path,
        help="a vehicle file (`incsvr identify --write`): learns every axis that it has an actuator for",
    )
    parser.add_argument(
        "--archive", metavar="DIR", type=Path, help="archive all messages in this folder, as MCAP files of limited size"
    )


def run(args: argparse.Namespace) -> int:
    if args.listen is not None:
        args.set.append(f"bus.listen={args.listen}")
    if args.archive is not None:
        args.set.append(f"archive.directory={json_text(str(args.archive))}")
    config = from_arguments(args, args.vehicle)
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="%(asctime)s %(levelname)s %(message)s")
    sys.setswitchinterval(THREAD_SWITCH_S)
    _keep_memory_small()
    serve(config, stop_event())
    return 0


def serve(config: Config, stop: threading.Event) -> None:
    """Runs every learner of the configuration until `stop` is set, and ends the process.

    Raises:
        BadInput: nobody said the inertia, the port is taken, another learner has the prefix, or the state cannot be
            kept where it is configured.
    """
    check_inertia(config)
    if config.bus.zenoh_file is not None:
        zenoh_config = from_file(config.bus.zenoh_file)
    elif config.bus.connect is not None:
        zenoh_config = client_config_at(config.bus.connect)
    else:
        zenoh_config = listener_config_at(config.bus.listen)
    patience = float("inf") if config.bus.connect is not None else 0.0
    try:
        session = open_session(zenoh_config, patience, stop)
    except BadInput:
        if stop.is_set():
            return  # told to stop while it waited for its router: that is no failure
        raise
    configs = config.each()
    try:
        hub = config.bus.connect is not None or config.bus.zenoh_file is not None
        taken = [take_prefix(session, each.prefix, stop, hub) for each in configs if not each.bus.allow_second]
        hosts = [Host(session, each, len(configs), each.thrust_axes(configs)) for each in configs]
        gc.freeze()  # what was loaded stays to the end: to look through it for garbage would delay an answer by 20 ms
        with WorkerThreads(hosts, lambda: tell_systemd(ALIVE), stroke_period()):
            for each in configs:
                for line in beginning(each):
                    log.info("%s: %s", each.prefix, line)
            log.info("ready: %s", ", ".join(host.keys.prefix for host in hosts))
            tell_systemd(READY)
            while not stop.wait(SIGNAL_WAIT_S):
                pass
            log.info("stopping")
            tell_systemd(STOPPING)
        del taken  # who comes sees the tokens until here
    finally:
        finish_in_time(session.close)
    # All is saved and said. To drop what the hosts declared, Zenoh would wait ten seconds for a client that does not
    # read: so the process ends while they are held here.
    logging.shutdown()
    sys.stderr.flush()
    os._exit(0)


def beginning(config: Config) -> tuple[str, ...]:
    """The lines at a learner's start: its endpoint, inputs, outputs and state."""
    bus, keys = config.bus, Keys(config.prefix)
    if bus.zenoh_file is not None:
        met = f"endpoints as in {bus.zenoh_file}"
    else:
        met = f"listens at {bus.listen}" if bus.connect is None else f"client of the router at {bus.connect}"
    received = f"receives {keys.rate}, {keys.torque} and {keys.any_channel}"
    if not config.inputs.own:
        # Loaded where it is needed alone, like what listens there.
        from service.bus.mapped_ingest import mapping
        from service.inputs.bus_keys import key_expressions

        received = f"receives {', '.join(key_expressions(mapping(config)))} and {keys.any_channel}"
    state = "nowhere (state: null)" if config.state is None else f"in {config.state / config.prefix}.sqlite"
    return (
        met,
        received,
        f"publishes {keys.model}, {keys.iteration}, {keys.coefficients}, {keys.health} and {keys.effects}; answers "
        f"{keys.damping}",
        f"keeps its state {state}",
        *([] if config.archive.directory is None else [f"archives all messages in {config.archive.directory}"]),
    )


def _keep_memory_small() -> None:
    """Lets threads share one heap and gives back what is free; 3 MB less, where the C library is glibc."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_ARENA_MAX, 1)
        mallopt(_TRIM_THRESHOLD, 65_536)
