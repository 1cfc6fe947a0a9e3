"""The page's HTTP server: GET alone, four paths, nothing of the vehicle can be changed through it."""

from __future__ import annotations

from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.metadata import version
from importlib.resources import files
from typing import Any
from urllib.parse import unquote, urlsplit

from service.wire.json_text import json_text
from viewer.page.learner import Learner, Recordings

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
    timeout = 30.0  # a client that sends nothing holds a thread no longer [s]

    def __init__(self, *args: Any, learner: Learner, recordings: Recordings, **more: Any) -> None:
        self._learner, self._recordings = learner, recordings
        super().__init__(*args, **more)

    def do_GET(self) -> None:
        path = unquote(urlsplit(self.path).path)
        if path in ("/", "/index.html"):
            self._send("text/html; charset=utf-8", files("viewer.page").joinpath("page.html").read_bytes())
        elif path == "/state.json":
            self._send("application/json", json_text(self._learner.state()).encode())
        elif path == "/register_service":
            self._send("application/json", json_text(SERVICE | {"name": self._learner.words["title"]}).encode())
        elif path.startswith("/recordings/"):
            self._recording(path.removeprefix("/recordings/"))
        else:
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such page")

    def log_message(self, format: str, *args: Any) -> None:
        """Once a second and browser nobody wants to read that all is well."""

    def _send(self, kind: str, body: bytes) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def _recording(self, name: str) -> None:
        path = self._recordings.path(name)
        if path is None:
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such recording")
            return
        with path.open("rb") as file:
            size = path.stat().st_size  # one that is being written grows on: what is there now is sent
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", "application/octet-stream")
            self.send_header("Content-Disposition", f'attachment; filename="{name}"')
            self.send_header("Content-Length", str(size))
            self.end_headers()
            while size > 0 and (part := file.read(min(size, 1 << 20))):
                self.wfile.write(part)
                size -= len(part)


def server(host: str, port: int, learner: Learner, recordings: Recordings) -> ThreadingHTTPServer:
    """A server that listens; `serve_forever` answers.

    Raises:
        OSError: the port is taken.
    """
    made = ThreadingHTTPServer((host, port), partial(Handler, learner=learner, recordings=recordings))
    made.daemon_threads = True
    return made
