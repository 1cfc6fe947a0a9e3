"""The page: served by a client of a real learner, drawn by a real browser."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest

from tests.viewer.conftest import PATIENCE, House, Run, learn_until, publish

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--disable-quic", "--dump-dom",
)  # fmt: skip


def drawn(url: str, folder: Path) -> str:
    """The document after its script has run, in a browser; the test is skipped where none is installed."""
    browser = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if browser is None:
        pytest.skip("no browser is installed (chromium)")
    command = [browser, *FLAGS, f"--user-data-dir={folder}", url]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=PATIENCE).stdout


def fetched(url: str) -> bytes:
    with urlopen(url, timeout=PATIENCE) as answer:
        return bytes(answer.read())


def state_with(url: str, iteration: int) -> dict[str, Any]:
    """What the page says once it has this iteration: one answer serves every browser for a while."""
    until = time.monotonic() + PATIENCE
    while True:
        state: dict[str, Any] = json.loads(fetched(f"{url}state.json"))
        if state["model"] is not None and state["model"]["iteration"] >= iteration:
            return state
        assert time.monotonic() < until, state
        time.sleep(0.1)


@pytest.mark.slow
def test_a_browser_draws_what_a_learner_says(house: House, run: Run, tmp_path: Path) -> None:
    learner = house.serve()
    page = house.start(["page", "--connect", house.endpoint, "--port", "0"])
    url = re.findall(r"http://\S+", page.wait_for("shows leng/yaw"))[0]
    assert "Nothing has been learned yet" in drawn(url, tmp_path / "before")
    session = house.client()
    learn_until(session, 3, lambda: publish(session, run.part(0.0, 100.0)))
    state = state_with(url, 3)
    assert {name: set(value) for name, value in state["model"]["coefficients"].items()} == {
        "N_r": {"estimate", "low", "high"},
        "N_r|r|": {"estimate", "low", "high"},
    }
    document = drawn(url, tmp_path / "after")
    assert 'data-drawn="curve"' in document
    assert len(re.findall(r'<circle [^>]*class="vectors"', document)) == len(state["model"]["support"]["rate"])
    assert re.search(r'<path d="M[\d.,L]{500,}" class="curve"', document)
    assert "rad/s" in document
    assert "N_r|r|, quadratic" in document
    assert re.search(r'id="level"[^>]*class="(OK|WARN|STALE)"', document)

    with pytest.raises(HTTPError, match="404"):
        fetched(f"{url}recordings/leng-yaw_000001.mcap")
    with pytest.raises(HTTPError, match="501"):
        urlopen(Request(f"{url}state.json", method="POST"), timeout=PATIENCE)

    assert learner.end() == 0
    away = drawn(url, tmp_path / "away")
    assert "learner does not answer" in away
    assert 'data-drawn="away"' in away, "by which the curve is dimmed"
    assert re.search(r'id="gone">The learner last answered at .* \((just now|1 min ago)\)', away)
    assert 'class="vectors"' in away, "the last curve stays"
    assert page.end() == 0


def test_the_page_needs_no_more_than_the_vehicle_has() -> None:
    """Neither Rerun, nor what the extras bring, is loaded to serve it."""
    program = (
        "import sys, viewer.page.server; "
        "sys.exit(sorted({'rerun', 'PIL', 'matplotlib', 'jinja2', 'mcap'} & set(sys.modules)))"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert ran.stderr.strip() in ("", "[]"), ran.stderr


@pytest.mark.slow
def test_a_port_that_is_taken_is_said(house: House) -> None:
    first = house.start(["page", "--connect", house.endpoint, "--port", "0"])
    port = re.findall(r":(\d+)/", first.wait_for("shows"))[0]
    second = house.start(["page", "--connect", house.endpoint, "--port", port])
    assert f"127.0.0.1:{port} cannot be served at" in second.wait_for("--port")
    assert second.wait() == 2
