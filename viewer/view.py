"""`incsvr view`: shows what a learner does, live, and records it; shows a recording."""

from __future__ import annotations

import argparse
import logging
import os
import socket
import subprocess
import sys
import threading
import time
from contextlib import nullcontext
from pathlib import Path

from incsvr.errors import BadInput
from service.bus.session import client_config, free_endpoint, open_session, stop_event
from service.config.configuration import Config
from service.config.sources import add_config_arguments, from_arguments
from service.wire import Keys
from viewer import window
from viewer.bus import Questions, Streams
from viewer.compare import Choice
from viewer.follow import Follower, Recordings
from viewer.pages import blueprint
from viewer.recorder import Recorder
from viewer.recording import Recording

log = logging.getLogger(__name__)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_config_arguments(parser)
    parser.add_argument(
        "recording", nargs="?", type=Path, metavar="FILE", help="show this recording (.rrd) instead of a learner"
    )
    parser.add_argument("--save", type=Path, metavar="FILE.rrd", help="record to this file, or to the next free one")
    parser.add_argument("--headless", action="store_true", help="open no window")
    parser.add_argument("--serve", type=int, metavar="PORT", help="serve viewers at this port of 127.0.0.1; no window")
    parser.add_argument(
        "--compare", nargs=2, type=int, metavar=("BEFORE", "AFTER"), help="iterations that are compared (first, latest)"
    )


def run(args: argparse.Namespace) -> int:
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="incsvr view: %(message)s")
    if args.recording is not None:
        return look(args.recording, headless=args.headless)
    if args.headless and args.save is None and args.serve is None:
        raise BadInput(
            "--headless shows nothing: give --save FILE.rrd to record, or --serve PORT for viewers elsewhere"
        )
    stop = stop_event()
    config = from_arguments(args)
    axis, rate = config.axis_asked, max(abs(end) for end in config.vehicle.rate_range)
    choice = Choice() if args.compare is None else Choice(*args.compare)
    opens = not args.headless and args.serve is None
    port = int(free_endpoint().rpartition(":")[2]) if opens else _checked(args.serve)

    def opened(path: Path | None) -> Recording:
        return Recording(Recorder(blueprint(axis=axis), path=path, port=port, axis=axis), choice, rate)

    recordings = Recordings(args.save, opened)
    with window.window("--connect", f"rerun+http://127.0.0.1:{port}/proxy") if opens else nullcontext() as process:
        if process is not None:
            threading.Thread(target=_ends_with, args=(process, stop), daemon=True).start()
        _follow(config, recordings, stop, until_broken=port is None)
    whole = recordings.close()
    if recordings.now.recorder.broken:
        # The stream of a file that cannot be written is never closed, and would keep the interpreter from ending.
        logging.shutdown()
        os._exit(1)
    return 0 if whole else 1


def _ends_with(process: subprocess.Popen[bytes], stop: threading.Event) -> None:
    """Whoever closes the window ends us."""
    process.wait()
    stop.set()


def look(path: Path, *, headless: bool) -> int:
    """Opens a recording in the viewer."""
    if not window.is_whole(path):
        log.warning("%s was cut off; it shows what was written until then", path)
    if headless:
        return 0
    with window.window(path) as process:
        return process.wait()


def _follow(config: Config, recordings: Recordings, stop: threading.Event, *, until_broken: bool) -> None:
    """Meets the learner, and follows it until `stop`."""
    where = config.bus.connect or config.bus.listen
    zenoh_config = client_config(config.bus)
    recordings.now.away(f"Waiting for the learner at {where}.", time.time())
    recordings.now.flush()
    log.info("waiting for the learner at %s, keys %s/…", where, config.prefix)
    try:
        session = open_session(zenoh_config, float("inf"), stop)
    except BadInput:
        if stop.is_set():
            return
        raise
    with session:
        keys = Keys(config.prefix)
        streams = Streams(session, keys)
        log.info("viewer ready")
        try:
            Follower(Questions(session, keys), streams, recordings).run(stop, until_broken=until_broken)
        finally:
            streams.close()


def _checked(port: int | None) -> int | None:
    """The port, where it can be listened at."""
    try:
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(("127.0.0.1", port or 0))
    except (OSError, OverflowError):
        raise BadInput(f"port {port} of 127.0.0.1 is taken or none; name a free one, such as --serve 9876") from None
    return port
