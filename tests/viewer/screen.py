"""Rerun's own viewer without a screen: opens a recording, goes to a page and an iteration, takes the picture.

It needs a Vulkan driver; Mesa's software one (mesa-vulkan-drivers) is enough.
"""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

from rerun.chunk import RrdReader
from rerun.experimental import View, ViewerClient

from incsvr.errors import BadInput
from service.bus.session import free_endpoint
from viewer.pages import PAGES
from viewer.window import BINARY

T = TypeVar("T")

SIZE = (1800, 1080)
PATIENCE_S = 60.0


@contextmanager
def on_screen(recording: Path) -> Iterator[Screen]:
    """A viewer on a recording.

    Raises:
        BadInput: it does not start.
    """
    port = free_endpoint().rpartition(":")[2]
    words = ["--headless", "--bind", "127.0.0.1", "--port", port, "--hide-welcome-screen"]
    size = f"{SIZE[0]}x{SIZE[1]}"
    with TemporaryDirectory() as folder, (Path(folder) / "viewer.log").open("w+b") as log:
        process = subprocess.Popen([BINARY, *words, "--window-size", size, recording], stdout=log, stderr=log)

        def connected() -> ViewerClient | None:
            """Once it has drawn the recording."""
            if process.poll() is not None:
                log.seek(0)
                raise BadInput(f"the viewer does not start: {_why(log.read().decode(errors='replace'))}")
            try:
                client = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
                state = client.get_state()
            except (RuntimeError, ConnectionError):  # it may answer, and end before it draws its first frame
                return None
            drawn = state.views and not state.loading and any(one.timelines for one in state.recordings)
            return client if drawn else None

        try:
            yield Screen(recording, _until(connected, "the viewer does not come"))
        finally:
            process.kill()
            process.wait()


class Screen:
    """What the viewer of a recording shows."""

    def __init__(self, recording: Path, viewer: ViewerClient) -> None:
        self._recording, self._viewer = recording, viewer
        self._started = time.monotonic()

    def show(self, page: str, iteration: int | None = None) -> None:
        """Goes to a page, and to an iteration; None is the end, on the vehicle's time.

        Raises:
            BadInput: the recording has no such iteration.
        """
        now = self._viewer.get_blueprint()
        for parts in now.blueprint.values():
            tabs = parts.get("ContainerBlueprint", {})
            if tabs.get("container_kind") == "Tabs":
                tabs["active_tab"] = tabs["contents"][PAGES.index(page)]
        self._viewer.set_blueprint(now.blueprint, store_id=now.store_id)
        if iteration is None:
            self._viewer.set_time("vehicle_time", play_state="following")
            return
        times = self._times()
        if iteration not in times:
            raise BadInput(f"the recording has no iteration {iteration}, its last is {max(times, default=0)}")
        self._viewer.set_time("vehicle_time", duration=times[iteration], play_state="paused")

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

        return _until(settled, "the picture never settles")

    def save(self, path: Path, notices_s: float = 9.0) -> None:
        """Saves the picture, once the viewer's own notices are gone from it [s]."""
        time.sleep(max(0.0, notices_s - (time.monotonic() - self._started)))
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(self.picture())


def _why(said: str) -> str:
    # without any adapter it says so; of one for OpenGL alone it gets no render context
    if any(words in said for words in ("graphics adapter", "No wgpu adapter", "Failed to get render context")):
        return "it finds no Vulkan driver; install mesa-vulkan-drivers"
    return (said.strip().splitlines() or ["it says nothing"])[-1][-300:]


def _until(ask: Callable[[], T | None], why: str) -> T:
    """Asks again until the answer is something, for PATIENCE_S at most."""
    end = time.monotonic() + PATIENCE_S
    while True:
        answer = ask()
        if answer:
            return answer
        if time.monotonic() > end:
            raise BadInput(why)
        time.sleep(0.05)
