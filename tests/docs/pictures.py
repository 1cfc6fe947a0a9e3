"""`make pictures`: the pictures of README and docs, from a recording of the demo, by the real viewer and a browser."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.request import urlopen

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

import incsvr
from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.bus.session import free_endpoint
from tests.viewer.screen import on_screen
from viewer.drawing import AFTER, BEFORE, STYLE

ITERATION = 15
"""The iteration whose page Learning is drawn: the cover has just been mounted."""
PAGE_ITERATION = 21
"""At which the picture of `incsvr page` is taken: seven after the cover was mounted."""
PAGE_SIZE = "1150,800"
ITERATION_TIMEOUT_S = 120.0
RUNS = {"without the cover": ("T1", BEFORE), "with the cover": ("T2", AFTER)}
"""The runs that the demo leaves beside its recording, and their colours."""
INERTIA = 350.0
"""Leng's, as the demo declares it [kg m²]."""
LOGS = Path("docs/logs")
"""The logs that come along, which the tutorial on a notebook reads."""
DPI = 150


def main(recording: Path, folder: Path) -> int:
    """Draws all pictures of a recording, such as out/leng.rrd of the demo, into a folder."""
    try:
        if not recording.is_file():
            raise BadInput(f"{recording}: there is no such recording; `make demo` makes one")
        with on_screen(recording) as screen:
            screen.show("Learning", ITERATION)
            screen.save(folder / f"iteration-{ITERATION:02d}.png")
            screen.show("Before and after")
            screen.save(folder / "before-and-after.png")
        draw_cover(recording.parent, folder / "cover.png")
        draw_notebook(LOGS, folder)
        draw_page(folder / "page.png")
    except BadInput as error:
        print(f"pictures: {error}", file=sys.stderr)
        return 2
    return 0


def draw_notebook(logs: Path, folder: Path) -> None:
    """What the cells of the tutorial on a notebook draw: the damping with its doubt, and a free run on unseen data."""
    run, unseen, inertia = logs / "rov.csv", logs / "rov_2.csv", 0.6
    incsvr.fit(run, validate=unseen, inertia=inertia).plot().savefig(folder / "damping.png", dpi=DPI)
    incsvr.trace(run, validate=unseen, inertia=inertia).plot().savefig(folder / "free_run.png", dpi=DPI)


def draw_cover(folder: Path, picture: Path) -> None:
    """The damping of the demo's vehicle without the cover and with it, and the difference with its band of 95 %.

    Each of the runs `T1.csv` and `T2.csv` of the folder is learned by itself, as `incsvr fit` does it. Damping opposes
    both turns alike: all is turned one way.

    Raises:
        BadInput: one of them is not there.
    """
    fits = {name: _fitted(folder / f"{run}.csv") for name, (run, _) in RUNS.items()}
    ends = [abs(end) for fit in fits.values() for end in fit.model.trained_range or ()]
    rate: Array = np.linspace(0.0, min(ends), 201, dtype=np.float64)
    with rc_context(STYLE | {"savefig.dpi": DPI, "font.size": 13, "legend.fontsize": 12}):
        figure = Figure(figsize=(10.0, 4.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        curves, doubts = [], []
        for name, fit in fits.items():
            colour, samples = RUNS[name][1], fit.pictures.samples
            turned = samples.damping * np.sign(samples.yaw_rate)
            left.plot(np.abs(samples.yaw_rate), turned, ".", color=colour, markersize=2.5, alpha=0.3)
            ahead, back = fit.predict(rate), fit.predict(-rate)
            curves.append((ahead.damping - back.damping) / 2.0)
            doubts.append((ahead.doubt + back.doubt) / 2.0)
            left.plot(rate, curves[-1], color=colour, linewidth=2.4, label=name)
        added, doubt = curves[1] - curves[0], 1.96 * np.hypot(*doubts)
        right.plot(rate, added, color=AFTER, linewidth=2.4, label="difference of the curves")
        right.fill_between(rate, added - doubt, added + doubt, color=AFTER, alpha=0.2, linewidth=0, label="95 %")
        right.axhline(0.0, color=BEFORE, linewidth=1.2)
        left.set(ylabel="Damping d(r) [N m]", title="What was learned", ylim=(0.0, None))
        right.set(ylabel="Damping that the cover adds [N m]", title="What the cover adds")
        for axes in (left, right):
            axes.set(xlabel="Yaw rate r [rad/s]", xlim=(0.0, rate[-1]))
            axes.legend(loc="upper left")
        figure.savefig(picture)


def _fitted(run: Path) -> Any:
    if not run.is_file():
        raise BadInput(f"{run}: there is no such run; `make demo` makes it")
    return incsvr.fit(run, inertia=INERTIA, config="config.yaml")


def draw_page(picture: Path) -> None:
    """`incsvr page` in a real browser, while a learner learns the experiment.

    Raises:
        BadInput: no browser is installed, or the learner does not come to PAGE_ITERATION.
    """
    browser = next((found for name in ("chromium", "google-chrome") if (found := shutil.which(name))), None)
    if browser is None:
        raise BadInput(f"{picture} is not drawn: no browser is installed (chromium)")
    with TemporaryDirectory() as folder, ExitStack() as stack:
        bus, page = free_endpoint(), f"http://{free_endpoint().removeprefix('tcp/')}/"
        settings = ("--set", f"state={folder}/state", "--set", "learner.policy=weighted", "--set", "learner.gamma=30")
        for words in (
            ("serve", "--listen", bus, *settings),
            ("page", "--connect", bus, "--port", page.rpartition(":")[2].rstrip("/")),
            ("simulate", "--connect", bus, "--speed", "40"),
        ):
            process = subprocess.Popen([sys.executable, "-m", "service.cli.command_line", *words])
            stack.callback(process.wait)
            stack.callback(process.terminate)
        _wait(page)
        flags = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars")
        command = [browser, *flags, f"--user-data-dir={folder}/browser", f"--window-size={PAGE_SIZE}"]
        subprocess.run([*command, f"--screenshot={picture}", page], check=True, stderr=subprocess.DEVNULL)


def _wait(page: str) -> None:
    """Until the learner has come to the iteration."""
    until = time.monotonic() + ITERATION_TIMEOUT_S
    while time.monotonic() < until:
        try:
            with urlopen(f"{page}state.json", timeout=5.0) as answer:
                model = json.load(answer).get("model")
        except OSError:
            model = None
        if model is not None and model["iteration"] >= PAGE_ITERATION:
            return
        time.sleep(0.2)
    raise BadInput(f"the learner does not come to iteration {PAGE_ITERATION} within {ITERATION_TIMEOUT_S:g} s")


if __name__ == "__main__":
    sys.exit(main(*map(Path, sys.argv[1:])))
