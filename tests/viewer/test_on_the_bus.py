"""The viewer beside a learner, as processes: late, restarted, killed, stopped; the learner gone; the disk full."""

from __future__ import annotations

import re
import shutil
import signal
import socket
import statistics
import subprocess
import time
from pathlib import Path

import pytest
import zenoh

from service.cli.command_line import main
from service.wire import SETS
from tests.viewer.conftest import KEYS, PATIENCE, House, Run, learn_until, publish
from tests.viewer.readback import every, points, rows, shown, verify
from viewer import window
from viewer.frame import positions


@pytest.mark.slow
def test_late_and_killed_it_loses_no_iteration_and_the_next_start_has_its_own_file(
    house: House, run: Run, tmp_path: Path
) -> None:
    path = tmp_path / "run.rrd"
    house.serve()
    session = house.client()
    t = [report.t + 1.5 for report, _ in run.iterations]
    learn_until(session, 2, lambda: publish(session, run.part(0.0, t[1])))

    late = house.view("--headless", "--save", str(path))
    late.wait_for("iteration 2 ")
    publish(session, run.part(t[1], t[2]))
    late.wait_for("iteration 3 ")
    late.end(signal.SIGKILL)
    assert set(rows(path, "Scalars:scalars")["/learning/revision"]) == {1, 2, 3}
    assert not window.is_whole(path)
    house.view("--headless", str(path)).wait_for("cut off")

    before = path.read_bytes()
    learn_until(session, 4, lambda: publish(session, run.part(t[2], t[3])))
    again = house.view("--headless", "--save", str(path))
    again.wait_for("iteration 4 ")
    publish(session, run.part(t[3], t[4]))
    again.wait_for("iteration 5 ")
    assert again.end() == 0
    assert path.read_bytes() == before
    second = tmp_path / "run-2.rrd"
    verify(second)
    assert window.is_whole(second)
    assert sorted(file.name for file in tmp_path.glob("*.rrd*")) == ["run-2.rrd", "run.rrd"]
    logged = rows(second, "Points2D:positions")
    # The learner on the bus learned what the one in this process did, so its numbers are known.
    for report, _ in run.iterations[:5]:
        for name in SETS:
            found = points(shown(logged[f"/learning/{name}"], report.iteration))
            assert found == pytest.approx(positions(getattr(report, name)), abs=1e-4), (name, report.iteration)


def test_no_curve_is_missing_where_the_learner_keeps_no_state(house: House, run: Run, tmp_path: Path) -> None:
    """By the time that the learner is asked for a model it has often made the next ones."""
    path = tmp_path / "run.rrd"
    house.serve(durable=False)
    viewer = house.view("--headless", "--save", str(path))
    viewer.wait_for("the learner is here")
    last = run.iterations[-1][0]
    publish(house.client(), run.part(0.0, last.t + 1.5))
    viewer.wait_for(f"iteration {last.iteration} ")
    assert viewer.end() == 0
    for number, (text,) in rows(path, "TextDocument:text")["/learning/table"].items():
        assert "curve is missing" not in text, f"iteration {number}"
    logged = rows(path, "LineStrips2D:strips")["/learning/function"]
    assert set(logged) == {report.iteration for report, _ in run.iterations}


@pytest.mark.slow
def test_it_waits_for_the_learner_says_so_and_begins_anew_with_it(house: House, run: Run, tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    viewer = house.view("--headless", "--save", str(path))
    viewer.wait_for("waiting for the learner")
    learner = house.serve()
    viewer.wait_for("viewer ready")
    viewer.wait_for("the learner is here")
    first = house.client()
    t = [report.t + 1.5 for report, _ in run.iterations]
    publish(first, run.part(0.0, t[0]))
    viewer.wait_for("iteration 1 ")
    learner.end(signal.SIGKILL)
    viewer.wait_for("the learner does not answer")
    learner = house.serve()
    viewer.wait_for("the learner is here")
    second = house.client()
    publish(second, run.part(t[0], t[2]))
    viewer.wait_for("iteration 2 ")
    learner.end(signal.SIGKILL)
    viewer.wait_for("the learner does not answer")
    shutil.rmtree(tmp_path / "state")  # the next learner knows nothing and counts from one again
    house.serve()
    viewer.wait_for("the learner is here")
    third = house.client()
    publish(third, run.part(0.0, t[0]))
    viewer.wait_for("a new recording begins")
    viewer.wait_for("iteration 1 ")
    assert viewer.end(signal.SIGINT) == 0
    first_of_two, second_of_two = (
        set(rows(each, "Scalars:scalars")["/learning/revision"]) for each in (path, tmp_path / "run-2.rrd")
    )
    assert first_of_two >= {1, 2}
    assert second_of_two == {1}
    # Health that is heard again before the next iteration stands at the same one: the text is sought among all rows.
    said = every(path, "TextDocument:text", "/signals/health/now")
    assert sum("LEARNER AWAY" in text and "does not answer" in text for text in said) == 2


@pytest.mark.slow
def test_a_hung_viewer_never_slows_the_learner(house: House, run: Run, tmp_path: Path) -> None:
    house.serve()
    session = house.client()
    t = [report.t + 1.5 for report, _ in run.iterations]
    learn_until(session, 1, lambda: publish(session, run.part(0.0, t[0])))
    viewer = house.view("--headless", "--save", str(tmp_path / "run.rrd"))
    viewer.wait_for("iteration 1 ")
    before = [latency(session) for _ in range(300)]
    viewer.signal(signal.SIGSTOP)
    # Two more iterations, and their thousands of measurements, while nobody empties the viewer's socket.
    began = time.monotonic()
    learn_until(session, 3, lambda: publish(session, run.part(t[0], t[2])))
    learning = time.monotonic() - began
    hung = [latency(session) for _ in range(300)]
    viewer.signal(signal.SIGCONT)
    viewer.wait_for("iteration 3 ")
    after = [latency(session) for _ in range(300)]
    assert viewer.end() == 0
    # Every question was answered, or latency had failed. Other work on this machine slows many questions at random, and
    # for a while all of them: so they are asked before and after, too. A learner that waits would slow them by far.
    assert tenth(hung) < 2.0 * max(tenth(before), tenth(after))
    assert max(hung) < 1.0
    assert learning < 10.0
    assert set(rows(tmp_path / "run.rrd", "Scalars:scalars")["/learning/revision"]) == {1, 2, 3}


@pytest.mark.slow
def test_when_the_disk_is_full_the_live_view_goes_on_at_loopback(house: House, run: Run, tmp_path: Path) -> None:
    path, seen = tmp_path / "run.rrd", tmp_path / "seen.rrd"
    house.serve()
    session = house.client()
    t = [report.t + 1.5 for report, _ in run.iterations]
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    viewer = house.view("--save", str(path), "--serve", str(port), limit_file=400_000)
    viewer.wait_for("viewer ready")
    assert listening(port) == {"127.0.0.1"}
    learn_until(session, 3, lambda: publish(session, run.part(0.0, t[2])))
    line = viewer.wait_for("cannot be written any more")
    assert "disk full" in line
    publish(session, run.part(t[2], t[4]))
    viewer.wait_for("iteration 5 ")
    watch(port, seen)
    assert viewer.end() == 1
    assert set(rows(seen, "Scalars:scalars")["/learning/revision"]) == {1, 2, 3, 4, 5}
    assert path.stat().st_size > 0


def listening(port: int) -> set[str]:
    """The addresses at which somebody on this machine listens at a port."""
    lines = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    bound = [words[1].split(":") for words in lines if words[3] == "0A"]
    return {socket.inet_ntoa(bytes.fromhex(host)[::-1]) for host, at in bound if int(at, 16) == port}


def watch(port: int, path: Path) -> None:
    """Comes as another viewer to what is served at a port, late, and keeps what it is given."""
    url = f"rerun+http://127.0.0.1:{port}/proxy"
    command = [str(window.BINARY), "--connect", url, "--save", str(path), "--bind", "127.0.0.1", "--port", "auto"]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as process:
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            try:
                if 5 in rows(path, "Scalars:scalars").get("/learning/revision", {}):
                    break
            except (ValueError, OSError, RuntimeError):
                pass  # not written yet
        process.terminate()


def tenth(latencies: list[float]) -> float:
    """What the quickest tenth stays below [s]."""
    return statistics.quantiles(latencies, n=10)[0]


def latency(session: zenoh.Session) -> float:
    """Of one question for the damping [s]."""
    began = time.perf_counter()
    (reply,) = list(session.get(f"{KEYS.damping}?rate=0.1", timeout=5.0))
    assert reply.ok is not None
    return time.perf_counter() - began


OLD, OTHER = b"RRF2" + bytes([0, 30, 1, 0]) + bytes(100), b"t,yaw_rate,torque\n"


@pytest.mark.parametrize(
    ("words", "file", "cure"),
    [
        (["--headless"], b"", "--save"),
        (["nowhere.rrd"], b"", "--save nowhere.rrd"),
        (["--serve", "99999"], b"", "--serve 9876"),
        (["--headless", "--save", "/proc/nowhere/run.rrd"], b"", "record elsewhere"),
        (["--headless", "--save", "/dev/full"], b"", "free some space"),
        (["run.rrd"], OLD, "Rerun 0.30.1 wrote this.* rerun-sdk==0.30.1"),
        (["run.rrd"], OTHER, "this is no recording of the viewer"),
    ],
)
def test_bad_input_gets_one_sentence_with_its_cure(
    words: list[str], file: bytes, cure: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    if file:
        Path("run.rrd").write_bytes(file)
    assert main(["view", *words]) == 2
    said = capsys.readouterr().err.strip()
    assert re.search(cure, said)
    assert len(said.splitlines()) == 1
