"""Rerun's own viewer without a screen: opens a recording, goes to a page and an iteration, takes the picture.

It needs a Vulkan driver; Mesa's software one (mesa-vulkan-drivers) is enough.
"""

from __future__ import annotations

import subprocess
import tempfile
import time
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path
from typing import Self, TypeVar

from rerun.chunk import RrdReader
from rerun.experimental import View, ViewerClient

from incsvr.errors import BadInput
from service.bus.session import free_endpoint
from viewer.pages import PAGES
from viewer.window import BINARY

T = TypeVar("T")

SIZE = (1800, 1080)
START_S, SETTLE_S = 60.0, 30.0
NOTICES_S = 9.0  # for so long the viewer's own notices lie over the plots after its start


class Screen:
    """A viewer on a recording, from `with` to its end."""

    def __init__(self, recording: Path) -> None:
        self._recording = recording
        self._folder = tempfile.TemporaryDirectory()
        port = int(free_endpoint().rpartition(":")[2])
        self._log = Path(self._folder.name) / "viewer.log"
        words = ["--headless", "--bind", "127.0.0.1", "--port", str(port), "--hide-welcome-screen"]
        with self._log.open("wb") as log:
            self._process = subprocess.Popen(
                [BINARY, *words, "--window-size", f"{SIZE[0]}x{SIZE[1]}", recording], stdout=log, stderr=log
            )
        self._url = f"rerun+http://127.0.0.1:{port}/proxy"
        self._viewer: ViewerClient
        self._started = time.monotonic()

    def __enter__(self) -> Self:
        try:
            self._viewer = _until(self._connected, START_S, self._why)
            _until(self._loaded, START_S, self._why)
        except BaseException:
            self._end()
            raise
        return self

    def __exit__(self, *error: object) -> None:
        self._end()

    def show(self, page: str, iteration: int | None = None) -> None:
        """Goes to a page, and to an iteration; None is the end, on the vehicle's time.

        Raises:
            BadInput: the recording has no such iteration.
        """
        client = self._viewer
        now = client.get_blueprint()
        for parts in now.blueprint.values():
            tabs = parts.get("ContainerBlueprint", {})
            if tabs.get("container_kind") == "Tabs":
                tabs["active_tab"] = tabs["contents"][PAGES.index(page)]
        client.set_blueprint(now.blueprint, store_id=now.store_id)
        if iteration is None:
            client.set_time("vehicle_time", play_state="following")
            return
        times = self._times()
        if iteration not in times:
            raise BadInput(f"the recording has no iteration {iteration}, its last is {max(times, default=0)}")
        client.set_time("vehicle_time", duration=times[iteration], play_state="paused")

    def _times(self) -> dict[int, timedelta]:
        """The vehicle's time of each iteration: the signals have no other clock."""
        reader, found = RrdReader(str(self._recording)), dict[int, timedelta]()
        for entry in reader.recordings():
            for chunk in reader.stream(store=entry).filter(content="/learning/revision", has_timeline="vehicle_time"):
                batch = chunk.to_record_batch()
                stamps = batch.column("vehicle_time").cast("int64").to_pylist()
                seconds = [timedelta(seconds=stamp / 1e9) for stamp in stamps]
                found |= dict(zip(batch.column("iteration").to_pylist(), seconds, strict=True))
        return found

    def views(self) -> list[View]:
        """What the viewer says about every view that it has drawn, with whatever it could not show."""
        self.picture()
        return list(self._viewer.get_state().views)

    def picture(self) -> bytes:
        """What is on the screen, PNG, as soon as it stands still."""
        still = [b""]

        def settled() -> bytes | None:
            still.append(self._viewer.take_screenshot())
            return still[-1] if still[-1] == still[-2] else None

        return _until(settled, SETTLE_S, lambda: "the picture never settles")

    def save(self, path: Path) -> None:
        """Saves the picture, once the viewer's own notices are gone from it."""
        time.sleep(max(0.0, NOTICES_S - (time.monotonic() - self._started)))
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(self.picture())

    def _connected(self) -> ViewerClient | None:
        self._check()
        try:
            client = ViewerClient.connect(self._url)
            client.get_state()
        except (RuntimeError, ConnectionError):
            return None
        return client

    def _loaded(self) -> bool:
        self._check()
        try:
            state = self._viewer.get_state()
        except (RuntimeError, ConnectionError):  # it may answer, and end before it draws its first frame
            return False
        return bool(state.views) and not state.loading and any(one.timelines for one in state.recordings)

    def _check(self) -> None:
        if self._process.poll() is not None:
            raise BadInput(f"the viewer does not start: {self._why()}")

    def _why(self) -> str:
        text = self._log.read_text(errors="replace")
        # without any adapter it says so; of one for OpenGL alone it gets no render context
        if any(words in text for words in ("graphics adapter", "No wgpu adapter", "Failed to get render context")):
            return "it finds no Vulkan driver; install mesa-vulkan-drivers"
        return (text.strip().splitlines() or ["it says nothing"])[-1][-300:]

    def _end(self) -> None:
        self._process.terminate()
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._folder.cleanup()


def _until(ask: Callable[[], T | None], seconds: float, why: Callable[[], str]) -> T:
    """Asks again until the answer is something, for at most this long [s]."""
    end = time.monotonic() + seconds
    while True:
        answer = ask()
        if answer:
            return answer
        if time.monotonic() > end:
            raise BadInput(f"the viewer does not come: {why()}")
        time.sleep(0.05)
