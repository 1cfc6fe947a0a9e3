"""A vehicle identified by way of the page: what a browser may ask, what bounds it, and what it gets."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.bus.session import client_config_at, free_endpoint
from service.config.vehicle_file import read_vehicle
from service.recordings.recording import from_streams
from service.recordings.recording_csv import write
from simulator.vehicles import torpedo
from tests.viewer.browser import opened_tab
from tests.viewer.conftest import PATIENCE
from tests.worlds import swim
from viewer.page import identification as identification_module
from viewer.page.hosts import ours
from viewer.page.identification import Identification
from viewer.page.learner import Learner
from viewer.page.recordings import Recordings
from viewer.page.server import MARK, Server, server

FITS = "document.documentElement.scrollWidth <= document.documentElement.clientWidth"
"""Whether a page needs no scrolling to the side."""
ASKED = {MARK: "1", "Origin": "http://localhost:9110"}


@pytest.fixture(scope="module")
def dive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two minutes of a torpedo."""
    path = tmp_path_factory.mktemp("dive") / "may.csv"
    write(path, from_streams("may", swim(torpedo(np.random.default_rng(54)), 130.0, 54)))
    return path


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Server]:
    """The page of a bus at which nobody listens, with an archive."""
    endpoint, recordings = free_endpoint(), Recordings(tmp_path)
    learner = Learner(client_config_at(endpoint), endpoint, "leng/yaw", recordings)
    identification = Identification()
    with server("127.0.0.1", 0, learner, recordings, ours("127.0.0.1", []), identification) as served:
        threading.Thread(target=served.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        yield served
        served.shutdown()
    identification.close()
    learner.close()


def url(page: Server) -> str:
    host, port = page.server_address[:2]
    return f"http://{host!s}:{port}/"


def asked(
    page: Server, method: str, path: str, body: bytes = b"", headers: dict[str, str] | None = None
) -> tuple[int, bytes, Any]:
    """Status, body and headers of an answer."""
    host, port = page.server_address[:2]
    connection = HTTPConnection(str(host), int(port), timeout=PATIENCE)
    connection.request(method, path, body=body or None, headers=headers or {})
    with connection.getresponse() as found:
        return found.status, found.read(), found.headers


def state(page: Server) -> dict[str, Any]:
    return dict(json.loads(asked(page, "GET", "/identify")[1]))


def await_state(page: Server, name: str) -> None:
    until = time.monotonic() + PATIENCE
    while (found := state(page))["state"] != name:
        assert time.monotonic() < until, found
        time.sleep(0.02)


def ended(page: Server) -> dict[str, Any]:
    """The state once nothing is at work."""
    until = time.monotonic() + PATIENCE
    while (found := state(page))["state"] in ("receiving", "running"):
        assert time.monotonic() < until, found
        time.sleep(0.1)
    return found


def process_of(page: Server) -> int:
    """The process at work: the one of our children that runs the job."""
    words = ["pgrep", "-P", str(os.getpid()), "-f", identification_module.JOB]
    found = subprocess.run(words, capture_output=True, text=True, check=True)
    return int(found.stdout.split()[0])


@pytest.mark.slow
def test_a_log_that_is_sent_is_identified_within_bounds_and_its_results_are_fetched(
    page: Server, dive: Path, tmp_path: Path
) -> None:
    status, body, _ = asked(page, "POST", "/identify?name=..%2Fmay.csv", dive.read_bytes(), headers=ASKED)
    assert (status, json.loads(body)["state"]) == (200, "running")
    number = process_of(page)
    status, body, _ = asked(page, "POST", "/identify?name=june.csv", dive.read_bytes(), headers=ASKED)
    assert (status, "may.csv is being identified" in json.loads(body)["why"]) == (409, True)
    assert asked(page, "GET", "/identify/report.html")[0] == 404
    steps = set()
    until = time.monotonic() + PATIENCE
    while (found := state(page))["state"] == "running":
        steps.add(found.get("step"))
        if found.get("step"):  # it has begun, within its bounds
            limits = Path(f"/proc/{number}/limits")
            text = limits.read_text() if limits.exists() else "Max address space 2147483648 Max cpu time 1800"
            assert re.search(r"Max address space +2147483648", text)
            assert re.search(r"Max cpu time +1800", text)
        assert time.monotonic() < until
        time.sleep(0.05)
    assert found["state"] == "done", found
    assert {"fitting all axes together", "predicting yaw by itself"} & steps
    assert [each["axis"] for each in found["errors"]] == ["surge", "sway", "yaw"]
    assert all(each["model"] < 0.3 * each["held"] for each in found["errors"])
    assert "heave: no heave was recorded" in found["missing"][0]
    status, report, headers = asked(page, "GET", "/identify/report.html")
    assert status == 200
    assert b"Surge, sway and yaw are identified" in report
    assert b"incsvr-page" not in report, "where the page keeps a log concerns nobody"
    assert headers["Content-Security-Policy"].startswith("sandbox allow-downloads; default-src 'none'")
    _, vehicle, headers = asked(page, "GET", "/identify/vehicle.yaml?download")
    assert headers["Content-Disposition"] == 'attachment; filename="may.yaml"'
    (tmp_path / "may.yaml").write_bytes(vehicle)
    assert read_vehicle(tmp_path / "may.yaml").axes == ("surge", "sway", "yaw")
    assert asked(page, "GET", "/identify/may.csv")[0] == 404, "the log is no result"


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 403),
        ({"Origin": "http://localhost"}, 403),
        ({MARK: "1", "Origin": "http://evil.example.org"}, 403),
        ({MARK: "1", "Origin": "null"}, 403),
        ({MARK: "1", "Host": "evil.example.org"}, 403),
    ],
)
def test_no_other_site_may_ask(page: Server, headers: dict[str, str], status: int) -> None:
    for path in ("/identify?name=may.csv", "/identify/stop"):
        assert asked(page, "POST", path, b"t,yaw_rate,torque\n", headers=headers)[0] == status
    assert state(page)["state"] == "none"


def test_it_is_stopped_and_ends_with_the_page(page: Server, dive: Path) -> None:
    assert asked(page, "POST", "/identify?name=may.csv", dive.read_bytes(), headers=ASKED)[0] == 200
    number = process_of(page)
    assert asked(page, "POST", "/identify/stop", headers=ASKED)[0] == 200
    assert ended(page)["why"] == "it was stopped"
    assert not Path(f"/proc/{number}").exists()
    # A page that is killed closes the pipe.
    words = [sys.executable, "-m", identification_module.JOB, str(dive.parent), str(dive)]
    job = subprocess.Popen(words, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL)
    assert job.stdin is not None
    job.stdin.close()
    assert job.wait(PATIENCE) == 1
    assert not (dive.parent / "report.html").exists()


def test_a_recording_of_the_archive_is_taken_and_nothing_beside_it(page: Server, dive: Path, tmp_path: Path) -> None:
    (tmp_path / "leng-yaw_000001.mcap").write_bytes(b"\x89MCAP0\r\n")
    for name in ("../may.csv", "leng-yaw_000002.mcap"):
        status, body, _ = asked(page, "POST", f"/identify?recording={name}", headers=ASKED)
        assert (status, json.loads(body)["why"]) == (409, f"there is no recording {name}")
    assert asked(page, "POST", "/identify?recording=leng-yaw_000001.mcap", headers=ASKED)[0] == 200
    found = ended(page)
    assert found["state"] == "failed"
    assert found["why"].startswith("leng-yaw_000001.mcap: ")


def test_a_log_that_lacks_something_is_answered_in_one_sentence(page: Server) -> None:
    log = b"t,r,torque\n" + b"".join(b"%.2f,0.1,2.0\n" % (0.1 * k) for k in range(200))
    assert asked(page, "POST", "/identify?name=a.csv&column=surge%3Du", log, headers=ASKED)[0] == 200
    found = ended(page)
    assert found["state"] == "failed"
    assert found["why"] == "--column surge=u: there is no u; `incsvr inspect FILE` lists all"


def test_a_log_that_is_too_large_empty_or_breaks_off_is_not_taken(
    page: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(identification_module, "MAX_LOG_BYTES", 1000)
    for body, why in ((b"x" * 1001, "the largest is"), (b"", "the log is empty")):
        status, said, _ = asked(page, "POST", "/identify?name=may.csv", body, headers=ASKED)
        assert (status, why in json.loads(said)["why"]) == (409, True)
    many = "".join(f"&column=a{k}" for k in range(25))
    assert asked(page, "POST", f"/identify?name=may.csv{many}", b"x", headers=ASKED)[0] == 409
    host, port = page.server_address[:2]
    connection = HTTPConnection(str(host), int(port), timeout=PATIENCE)
    connection.putrequest("POST", "/identify?name=may.csv")
    for name, value in {**ASKED, "Content-Length": "500"}.items():
        connection.putheader(name, value)
    connection.endheaders(b"t,yaw_rate")
    await_state(page, "receiving")
    connection.close()
    await_state(page, "none")


@pytest.mark.slow
def test_a_vehicle_without_what_draws_a_report_gives_the_model(
    page: Server, dive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "matplotlib.py").write_text("raise ModuleNotFoundError(name='matplotlib')\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    assert asked(page, "POST", "/identify?name=may.csv", dive.read_bytes(), headers=ASKED)[0] == 200
    found = ended(page)
    assert found["state"] == "done", found
    assert found["no_report"].startswith("the report needs matplotlib")
    assert asked(page, "GET", "/identify/vehicle.yaml")[0] == 200
    assert asked(page, "GET", "/identify/report.html")[0] == 404


@pytest.mark.slow
def test_a_browser_chooses_a_log_and_shows_its_report_also_on_a_phone(page: Server, dive: Path, tmp_path: Path) -> None:
    with opened_tab(tmp_path / "browser") as tab:
        tab.open(url(page), 390, 900)
        tab.wait_for("document.body.dataset.drawn && !document.getElementById('identify').hidden")
        tab.choose("#log", dive)
        tab.wait_for("document.getElementById('bar').value > 0 && !document.getElementById('work').hidden")
        assert tab.value(FITS)
        tab.wait_for("!document.getElementById('found').hidden")
        for width in (390, 1400):
            tab.open(url(page), width, 900)
            tab.wait_for("document.querySelectorAll('#ahead tr').length === 4")
            assert "may.csv is identified" in tab.value("document.getElementById('said').textContent")
            assert tab.value(FITS)
            tab.picture(tmp_path / f"page-{width}.png")
            tab.open(f"{url(page)}identify/report.html", width, 900)
            tab.wait_for("document.querySelectorAll('figure svg').length === 3")
            assert tab.value(FITS)
