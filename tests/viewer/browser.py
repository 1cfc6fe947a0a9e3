"""A real browser that a test drives over the pipe of Chromium's DevTools protocol."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import pytest

from tests.viewer.conftest import PATIENCE

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--disable-quic",
)  # fmt: skip
LAUNCH = """
import fcntl, os, sys
reads, writes = (fcntl.fcntl(int(number), fcntl.F_DUPFD, 100) for number in sys.argv[1:3])
os.dup2(reads, 3)
os.dup2(writes, 4)
os.execv(sys.argv[3], sys.argv[3:])
"""
"""Puts the pipes at descriptors 3 and 4, where the browser reads commands and answers them."""


def browser_or_skip() -> str:
    """The browser's program; the test is skipped where none is installed."""
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        pytest.skip("no browser is installed (chromium)")
    return found


class Tab:
    """One page in the browser."""

    def __init__(self, asks: IO[bytes], answers: IO[bytes]) -> None:
        self._asks, self._answers, self._number, self._session = asks, answers, 0, ""
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]

    def ask(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The answer to a command of the protocol."""
        self._number += 1
        asked = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            asked["sessionId"] = self._session
        self._asks.write(json.dumps(asked).encode() + b"\0")
        self._asks.flush()
        while True:
            said = b""
            while not said.endswith(b"\0"):
                piece = self._answers.read(1)
                assert piece, "the browser is gone"
                said += piece
            answer = json.loads(said[:-1])
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return dict(answer["result"])

    def open(self, url: str, width: int, height: int) -> None:
        """Shows a page in a window of this size, as on a phone where it is narrow."""
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self.ask("Emulation.setDeviceMetricsOverride", **metrics)
        self.ask("Page.navigate", url=url)

    def value(self, expression: str) -> Any:
        """What a script says."""
        found = self.ask("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def wait_for(self, expression: str) -> None:
        """Returns once a script says that it is so."""
        until = time.monotonic() + PATIENCE
        # A page that is being loaded lacks what the expression speaks of.
        while not self.value(f"(() => {{ try {{ return Boolean({expression}); }} catch {{ return false; }} }})()"):
            assert time.monotonic() < until, self.value("document.body.innerText")
            time.sleep(0.1)

    def choose(self, selector: str, path: Path) -> None:
        """Chooses a file in an input."""
        root = self.ask("DOM.getDocument")["root"]["nodeId"]
        node = self.ask("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self.ask("DOM.setFileInputFiles", nodeId=node, files=[str(path)])

    def picture(self, path: Path) -> None:
        """Writes the page as a PNG, from its top to its end."""
        found = self.ask("Page.captureScreenshot", captureBeyondViewport=True)
        path.write_bytes(base64.b64decode(found["data"]))


@contextmanager
def opened_tab(folder: Path) -> Iterator[Tab]:
    """A tab of a browser that keeps its own files in `folder`."""
    program = browser_or_skip()
    (ask_read, ask_write), (answer_read, answer_write) = os.pipe(), os.pipe()
    flags = [*FLAGS, "--remote-debugging-pipe", f"--user-data-dir={folder}"]
    words = [sys.executable, "-c", LAUNCH, str(ask_read), str(answer_write), program, *flags]
    process = subprocess.Popen(words, pass_fds=(ask_read, answer_write), stderr=subprocess.DEVNULL)
    os.close(ask_read)
    os.close(answer_write)
    try:
        with os.fdopen(ask_write, "wb") as asks, os.fdopen(answer_read, "rb") as answers:
            yield Tab(asks, answers)
    finally:
        process.kill()
        process.wait()
