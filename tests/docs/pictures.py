"""`make pictures`: the pictures of README and docs, from a recording of the demo, by the real viewer and a browser."""

from __future__ import annotations

import json
import runpy
import shutil
import subprocess
import sys
import textwrap
import time
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.request import urlopen

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import imread, imsave

import incsvr
from incsvr.errors import BadInput
from incsvr.forecasting.over_recordings import FitPictures
from incsvr.numerics import Array
from service.bus.session import free_endpoint
from simulator.dive_log import write_dive
from simulator.leng_at_sea import write_log
from tests.viewer.screen import on_screen
from viewer.drawing import AFTER, BEFORE, MEASURED, STYLE

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
RATE_BINS = 14
"""Bins of the yaw rate for the means of the samples."""
STUCK_S, SERVED_AT = (150.0, 195.0), 0.2
"""When the gyro of the picture of health repeats a value [s]; the yaw rate whose damping is drawn [rad/s]."""
DARK: Array = np.array([13.0, 17.0, 23.0]) / 255.0
"""The page that the dark pictures are made for: GitHub's."""


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
        draw_results(folder)
        draw_health(folder / "health.png")
        draw_page(folder / "page.png")
    except BadInput as error:
        print(f"pictures: {error}", file=sys.stderr)
        return 2
    return 0


def draw_results(folder: Path) -> None:
    """What `plot()` of each result draws: the damping with its doubt, a free run on unseen data, axes, and dives."""
    run: dict[str, Any] = {"inertia": 0.6, "validate": LOGS / "rov_2.csv"}
    with TemporaryDirectory() as place:
        rov = [Path(place, f"rov_{seed}.csv") for seed in (1, 2)]
        for seed, path in enumerate(rov):
            write_dive(path, "rov", seed + 1)
        months = runpy.run_path(str(LOGS / "dives.py"))["main"](Path(place))
        results = {
            "damping": incsvr.fit(LOGS / "rov.csv", **run),
            "free_run": incsvr.trace(LOGS / "rov.csv", **run),
            "axes": incsvr.identify(rov[0], validate=rov[1]),
            "dives": incsvr.compare(months),
        }
    for name, result in results.items():
        _keep(result.plot(), folder / f"{name}.png")


def draw_health(picture: Path) -> None:
    """A gyro that repeats one value: when the learner pauses and why, and what it serves meanwhile."""
    with TemporaryDirectory() as place:
        log = Path(place, "leng.csv")
        write_log(log, 1)
        time, rate, torque = np.genfromtxt(log, delimiter=",", skip_header=1, unpack=True)
    begin, end = np.searchsorted(time, STUCK_S)
    rate[begin:end][np.isfinite(rate[begin:end])] = rate[:begin][np.isfinite(rate[:begin])][-1]
    learner, served = incsvr.Learner(inertia=INERTIA, config=Path("config.yaml")), []
    for now, *measured in zip(time, rate, torque, strict=True):
        learner.push(now, *measured)
        if learner.model.is_trained:
            at = learner.damping(SERVED_AT)
            served.append((now, float(at.damping[0]), 1.96 * float(at.doubt[0]), learner.paused))
    known, (when, damping, doubt, why) = np.isfinite(rate), zip(*served, strict=True)
    paused = np.array([each is not None for each in why])
    with rc_context(STYLE | {"font.size": 12, "legend.fontsize": 12}):
        figure = Figure(figsize=(8.0, 5.0), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        above.plot(time[known], rate[known], color=MEASURED, linewidth=1.1, label="measured: the gyro stops for 45 s")
        above.set(ylabel="yaw rate r [rad/s]", ylim=(-0.22, 0.39))
        low, high = np.subtract(damping, doubt), np.add(damping, doubt)
        below.fill_between(when, low, high, color=AFTER, alpha=0.25, linewidth=0)
        below.plot(when, damping, color=AFTER, linewidth=1.8, label=f"damping served at {SERVED_AT} rad/s, 95 %")
        below.set(xlabel="time t [s]", ylabel="damping d [N m]", ylim=(0.0, 140.0))
        for axes in (above, below):
            shade = {"color": BEFORE, "alpha": 0.15, "linewidth": 0, "label": "learning paused"}
            axes.fill_between(when, 0.0, 1.0, paused, transform=axes.get_xaxis_transform(), **shade)
            axes.legend(loc="upper left", ncols=2)
        figure.suptitle(textwrap.fill(f"health: {next(filter(None, why))}", 70), fontsize=12)
    _keep(figure, picture)


def _keep(figure: Figure, picture: Path) -> None:
    """The figure for a light page, and for a dark one: of each colour the lightness turns round, the hue stays."""
    figure.savefig(picture, dpi=DPI)
    light = imread(picture)[..., :3]
    turned = light + 1.0 - (light.max(axis=-1, keepdims=True) + light.min(axis=-1, keepdims=True))
    imsave(picture.with_stem(f"{picture.stem}-dark"), DARK + (1.0 - DARK) * turned)


def draw_cover(folder: Path, picture: Path) -> None:
    """The damping of the demo's vehicle without the cover and with it, and the difference.

    Each of the runs `T1.csv` and `T2.csv` of the folder is learned by itself, as `incsvr fit` does it.

    Raises:
        BadInput: one of them is not there.
    """
    learned = {name: _learned(folder / f"{run}.csv") for name, (run, _) in RUNS.items()}
    fastest = min(max(abs(end) for end in each.model.trained_range or (0.0, 0.0)) for each in learned.values())
    rate: Array = np.linspace(0.0, fastest, 201, dtype=np.float64)
    with rc_context(STYLE | {"font.size": 13, "legend.fontsize": 12}):
        figure = Figure(figsize=(10.0, 4.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        _curves(left, rate, learned)
        _difference(right, rate, learned)
        for axes in (left, right):
            axes.set(xlabel="Yaw rate r [rad/s]", xlim=(0.0, rate[-1]))
            axes.legend(loc="upper left")
    _keep(figure, picture)


def _learned(run: Path) -> FitPictures:
    if not run.is_file():
        raise BadInput(f"{run}: there is no such run; `make demo` makes it")
    fit: Any = incsvr.fit(run, inertia=INERTIA, config="config.yaml")
    learned: FitPictures = fit.pictures
    return learned


def _curves(axes: Axes, rate: Array, learned: dict[str, FitPictures]) -> None:
    for name, each in learned.items():
        turns, damping = _one_way(each)
        colour = RUNS[name][1]
        axes.plot(turns, damping, ".", color=colour, markersize=2.5, alpha=0.3)
        axes.plot(rate, _both_ways(each, rate), color=colour, linewidth=2.4, label=name)
    axes.set(ylabel="Damping d(r) [N m]", title="What was learned", ylim=(0.0, None))


def _difference(axes: Axes, rate: Array, learned: dict[str, FitPictures]) -> None:
    """By how much samples and curve with the cover lie above those without it."""
    edges: Array = np.linspace(0.0, rate[-1], RATE_BINS + 1, dtype=np.float64)
    means, errors = zip(*(_means(each, edges) for each in learned.values()), strict=True)
    middle, doubt = (edges[1:] + edges[:-1]) / 2.0, 1.96 * np.hypot(*errors)
    axes.errorbar(
        middle, means[1] - means[0], doubt, fmt="o", color=MEASURED, markersize=5.0, label="means of samples, 95 %"
    )
    curves = [_both_ways(each, rate) for each in learned.values()]
    axes.plot(rate, curves[1] - curves[0], color=AFTER, linewidth=2.4, label="learned curves")
    axes.axhline(0.0, color=BEFORE, linewidth=1.2)
    axes.set(ylabel="Damping that the cover adds [N m]", title="What the cover adds")


def _means(learned: FitPictures, edges: Array) -> tuple[Array, Array]:
    """(RATE_BINS,) the samples' damping between two edges, less what the curve bends there, and standard errors."""
    turns, damping = _one_way(learned)
    place = np.digitize(turns, edges) - 1
    middle = (edges[1:] + edges[:-1]) / 2.0
    level = damping - _both_ways(learned, turns) + _both_ways(learned, middle)[np.clip(place, 0, RATE_BINS - 1)]
    parts = [level[place == k] for k in range(RATE_BINS)]
    means = np.array([part.mean() if part.size else np.nan for part in parts])
    errors = np.array([part.std() / np.sqrt(part.size) if part.size else np.nan for part in parts])
    return means, errors


def _one_way(learned: FitPictures) -> tuple[Array, Array]:
    """(n,) rates and damping of all samples, turned one way: damping opposes both turns alike."""
    rate, damping = learned.samples.yaw_rate, learned.samples.damping
    return np.abs(rate), damping * np.sign(rate)


def _both_ways(learned: FitPictures, rate: Array) -> Array:
    """(n,) the learned damping at rates ≥ 0, the mean of both turns [N m]."""
    left, right = (learned.model.predict(side * rate).damping for side in (1.0, -1.0))
    return np.asarray((left - right) / 2.0)


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
        settings = ("--set", f"state={folder}/state", "--set", "learner.policy=weighted")
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
