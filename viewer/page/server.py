"""The page's HTTP server: GET of a few paths; nothing of the vehicle can be changed through it.

Where it was started with `--identify`, a POST has the vehicle of one log identified, or stops that. A web site cannot
send it: a browser asks before it sends the header MARK to another origin, and is not answered.

Each client has a thread of its own, so that one that is slow or silent holds up no other. Beyond MAX_CLIENTS the one
that has been silent longest is cut off.
"""

from __future__ import annotations

import logging
import os
import socket
import sys
import threading
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit

from service.wire.json_text import json_text
from viewer.page.hosts import foreign
from viewer.page.identification import RESULTS, Identification, Refused
from viewer.page.learner import Learner
from viewer.page.recordings import Recordings
from viewer.page.vehicle_axes import VehicleAxes

log = logging.getLogger(__name__)

MAX_CLIENTS = 400
"""Connections at a time: a thread each, of some 50 kB. Twice the clients that a page was asked to bear."""
MARK = "X-Incsvr-Page"
"""The header of each POST of the page's own script."""
HARMLESS = "sandbox allow-downloads; default-src 'none'; style-src 'unsafe-inline'; img-src data:"
"""Content security of a report, which holds names out of a log: it can run no script and load nothing."""
MAX_SILENCE_S = 30.0
"""A client that sends or takes nothing for so long [s] is cut off."""
SERVICE = {
    "description": "Learns the vehicle's damping while it moves, and what its model lacks",
    "icon": "mdi-chart-bell-curve-cumulative",
    "company": "incsvr",
    "version": version("incsvr"),
    "new_page": False,
    "webpage": "",
    "api": "",
    "works_in_relative_paths": True,
}
"""What BlueOS asks every web server for, at /register_service, before it shows it in its menu."""


class Handler(BaseHTTPRequestHandler):
    """Answers one request."""

    server_version = "incsvr"
    sys_version = ""
    timeout = MAX_SILENCE_S

    def __init__(
        self,
        *args: Any,
        axes: VehicleAxes,
        title: str,
        recordings: Recordings,
        names: frozenset[str],
        identification: Identification | None = None,
        **more: Any,
    ) -> None:
        self._axes, self._title, self._recordings, self._names = axes, title, recordings, names
        self._identification = identification
        super().__init__(*args, **more)

    def do_GET(self) -> None:
        if not self._is_for_us():
            return
        path = unquote(urlsplit(self.path).path)
        if path in ("/", "/index.html"):
            self._send("text/html; charset=utf-8", files("viewer.page").joinpath("page.html").read_bytes())
        elif path == "/state.json":
            axis = parse_qs(urlsplit(self.path).query).get("axis", [None])[0]
            self._send("application/json", json_text(self._axes.state(axis)).encode())
        elif path == "/identify":
            own = None if self._identification is None else self._identification.state()
            self._send("application/json", json_text(own).encode())
        elif path == "/register_service":
            self._send("application/json", json_text(SERVICE | {"name": self._title}).encode())
        elif path.startswith("/recordings/"):
            self._recording(path.removeprefix("/recordings/"))
        elif path.startswith("/identify/"):
            self._result(path.removeprefix("/identify/"))
        else:
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such page")

    def do_POST(self) -> None:
        if self._identification is None:
            self.send_error(HTTPStatus.NOT_IMPLEMENTED, "this page was not started with --identify")
            return
        if not self._is_for_us():
            return
        origins = [urlsplit(origin).netloc for origin in self.headers.get_all("Origin", [])]
        if MARK not in self.headers or foreign(origins, self._names) is not None:
            self.send_error(HTTPStatus.FORBIDDEN, "only the page itself may ask for that")
            return
        asked = urlsplit(self.path)
        if asked.path == "/identify/stop":
            self._identification.stop()
        elif asked.path == "/identify":
            try:
                self._identify(self._identification, parse_qs(asked.query))
            except Refused as reason:
                self.send_response(HTTPStatus.CONFLICT)
                self._finish("application/json", json_text({"why": str(reason)}).encode())
                return
        else:
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such page")
            return
        self._send("application/json", json_text(self._identification.state()).encode())

    def _is_for_us(self) -> bool:
        """Whether the request calls us by a name of ours; else it is refused."""
        if isinstance(self.server, Server):
            self.server.asked(self.connection)
        host = foreign(self.headers.get_all("Host", []), self._names)
        if host is not None:
            why_not = "the page is not served under this name; call it by its address, or start it with --name NAME"
            self.send_error(HTTPStatus.FORBIDDEN, explain=why_not)
        return host is None

    def _identify(self, identification: Identification, asked: dict[str, list[str]]) -> None:
        """Begins with a recording of the archive, or with the log that the request brings.

        Raises:
            Refused: it is not taken.
        """
        columns = asked.get("column", [])
        if "recording" in asked:
            name = asked["recording"][0]
            file = self._recordings.opened(name)
            if file is None:
                raise Refused(f"there is no recording {name}")
            with file:
                identification.start(name, file, os.fstat(file.fileno()).st_size, columns)
            return
        length = self.headers.get("Content-Length", "")
        size = int(length) if length.isascii() and length.isdigit() else 0
        identification.start(asked.get("name", ["log"])[0], self.rfile, size, columns)

    def _result(self, name: str) -> None:
        found = None if self._identification is None else self._identification.result(name)
        if found is None or self._identification is None:
            self.send_error(HTTPStatus.NOT_FOUND, "there is no result yet")
            return
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Security-Policy", HARMLESS)
        self.send_header("X-Content-Type-Options", "nosniff")
        kept = f"{self._identification.vehicle}{Path(name).suffix}"
        how = "attachment" if urlsplit(self.path).query == "download" else "inline"
        self.send_header("Content-Disposition", f'{how}; filename="{kept}"')
        self._finish(RESULTS[name], found)

    def log_message(self, format: str, *args: Any) -> None:
        """Once a second and browser nobody wants to read that all is well."""

    def _send(self, kind: str, body: bytes) -> None:
        self.send_response(HTTPStatus.OK)
        self._finish(kind, body)

    def _finish(self, kind: str, body: bytes) -> None:
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def _recording(self, name: str) -> None:
        file = self._recordings.opened(name)
        if file is None:
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such recording")
            return
        with file:
            size = os.fstat(file.fileno()).st_size  # one that is being written grows on: what is there now is sent
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", "application/octet-stream")
            self.send_header("Content-Disposition", f'attachment; filename="{name}"')
            self.send_header("Content-Length", str(size))
            self.end_headers()
            while size > 0 and (part := file.read(min(size, 1 << 20))):
                self.wfile.write(part)
                size -= len(part)


class Server(ThreadingHTTPServer):
    """A bounded number of clients at a time."""

    daemon_threads = True
    request_queue_size = MAX_CLIENTS  # that connect in the same moment

    def __init__(self, *args: Any) -> None:
        self._clients: dict[socket.socket, bool] = {}  # in the order in which they came; whether each has asked
        self._lock = threading.Lock()
        super().__init__(*args)

    @property
    def clients(self) -> int:
        """How many are connected."""
        with self._lock:
            return len(self._clients)

    def asked(self, client: socket.socket) -> None:
        """This client has sent its request."""
        with self._lock:
            self._clients[client] = True

    def process_request(self, request: Any, client_address: Any) -> None:
        with self._lock:
            if len(self._clients) >= MAX_CLIENTS:
                silent = (client for client, asked in self._clients.items() if not asked)
                oldest = next(silent, next(iter(self._clients)))
                del self._clients[oldest]
                _cut_off(oldest)
            self._clients[request] = False
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        with self._lock:
            self._clients.pop(request, None)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A client that breaks off is no error; what is one takes one line."""
        error = sys.exception()
        if not isinstance(error, OSError):
            log.error("the page: a fault of this program: %s: %s", type(error).__name__, error)


def server(
    host: str,
    port: int,
    learner: Learner,
    recordings: Recordings,
    names: frozenset[str],
    identification: Identification | None = None,
) -> Server:
    """A server that listens; `serve_forever` answers.

    Args:
        names: under which browsers may call it, beside addresses (`hosts.ours`).
        identification: what a browser may ask for; None leaves the page without a POST.

    Raises:
        OSError: the port is taken.
    """
    handler = partial(
        Handler,
        axes=VehicleAxes(learner),
        title=learner.words["title"],
        recordings=recordings,
        names=names,
        identification=identification,
    )
    return Server((host, port), handler)


def _cut_off(client: socket.socket) -> None:
    """Ends a connection under the thread that waits for it, which then closes it."""
    try:
        client.shutdown(socket.SHUT_RDWR)
    except OSError:
        return  # it has ended by itself
