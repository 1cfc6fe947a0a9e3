"""`python -m viewer.page.picture FILE.png`: the page in a real browser, while a learner learns the experiment."""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.request import urlopen

from service.bus.session import free_endpoint

ITERATION = 21
"""At which the picture is taken: seven after the hull was mounted."""
SIZE = "1150,800"
ITERATION_TIMEOUT_S = 120.0


def main() -> int:
    parser = argparse.ArgumentParser(description="Draws the page in a browser.")
    parser.add_argument("picture", type=Path, help="the PNG to write")
    picture: Path = parser.parse_args().picture
    browser = next((found for name in ("chromium", "google-chrome") if (found := shutil.which(name))), None)
    if browser is None:
        print(f"{picture} is not drawn: no browser is installed (chromium)", file=sys.stderr)
        return 1
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
        flags = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=1500")
        command = [browser, *flags, f"--user-data-dir={folder}/browser", f"--window-size={SIZE}"]
        subprocess.run([*command, f"--screenshot={picture}", page], check=True, stderr=subprocess.DEVNULL)
    return 0


def _wait(page: str) -> None:
    """Until the learner has come to the iteration."""
    until = time.monotonic() + ITERATION_TIMEOUT_S
    while time.monotonic() < until:
        try:
            with urlopen(f"{page}state.json", timeout=5.0) as answer:
                model = json.load(answer).get("model")
        except OSError:
            model = None
        if model is not None and model["iteration"] >= ITERATION:
            return
        time.sleep(0.2)
    raise SystemExit(f"the learner does not come to iteration {ITERATION} within {ITERATION_TIMEOUT_S:g} s")


if __name__ == "__main__":
    sys.exit(main())
