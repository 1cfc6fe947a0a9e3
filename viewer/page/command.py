"""`incsvr page`: serves a learner's status, curve and effects to a browser."""

from __future__ import annotations

import argparse
import sys
import threading

from incsvr.errors import BadInput
from service.bus.session import client_config, stop_event
from service.config.sources import add_config_arguments, from_arguments
from viewer.page.hosts import ours
from viewer.page.learner import Learner
from viewer.page.server import server


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_config_arguments(parser)
    parser.add_argument("--host", default="127.0.0.1", help="address of the page (default 127.0.0.1)")
    parser.add_argument("--port", type=int, default=9110, help="port of the page; 0 for any (default 9110)")
    parser.add_argument(
        "--name",
        action="append",
        default=[],
        help="further host name of the page, such as rov.example.org; addresses, this machine's name and names in "
        ".local are always served",
    )


def run(args: argparse.Namespace) -> int:
    stop = stop_event()
    config = from_arguments(args)
    where = config.bus.connect or config.bus.listen
    learner = Learner(client_config(config.bus), where, config.prefix, config.axis_asked)
    try:
        served = server(args.host, args.port, learner, ours(args.host, args.name))
    except (OSError, OverflowError) as error:
        raise BadInput(
            f"{args.host}:{args.port} cannot be served at ({error}); name another one with --host and --port"
        ) from None
    host, port = served.server_address[:2]
    print(f"incsvr page: http://{host!s}:{port}/ shows {config.prefix} of {where}", file=sys.stderr, flush=True)
    answering = threading.Thread(target=served.serve_forever, daemon=True)
    answering.start()
    while not stop.wait(1.0):
        pass
    served.shutdown()
    served.server_close()
    learner.close()
    return 0
