"""What a terminal shows of a running learner: `incsvr status`, also with `--follow`, and the log of `incsvr serve`."""

from __future__ import annotations

import json
import queue
import re
import signal
import subprocess
import threading
import time
from collections import deque
from pathlib import Path

import pytest

from incsvr.plant.axes import AXES
from service import wire
from service.bus.session import free_endpoint
from service.cli.command_line import main
from service.cli.output import WIDTH, iteration_line
from service.commands.query import not_learned, table
from service.commands.status import text
from tests.service.commands.test_processes import KEYS, client_after, command, endpoint, following, next_model
from tests.service.conftest import PATIENCE, teach

__all__ = ["endpoint"]

STARVED = "torque waits for yaw rate, whose stamps are 3600.0 s behind (12.3 s and 3612.3 s); stamp both with one clock"


@pytest.fixture
def health() -> wire.Health:
    """A health with everything in it that a screen must find room for."""
    return wire.Health(
        level="WARN",
        reasons=(f"learning is starved: {STARVED}", "12345 values rejected: clock jump"),
        counters={"samples": 1234567, "iterations": 24691, "rejected": 12345, "rejected:clock_jump": 12345},
        learned=0.95,
        boot="b",
        revision=24691,
        iteration=24691,
        uptime_s=400_000.0,
        streams={
            "yaw_rate": wire.StreamHealth(
                received=123456789, lost=1234, age_s=0.02, t=1764040000.0, value=-0.0834, period_s=0.02, held=200_000
            ),
            "torque": wire.StreamHealth(),
            "thruster_1_speed_measured": wire.StreamHealth(received=5, age_s=12.0, t=3.0, value=141.4, held=5),
        },
        learning=wire.Learning(state="starved", since=8.1, why=STARVED),
    )


def test_the_screen_fits_and_says_what_is_wrong(health: wire.Health) -> None:
    model = wire.ModelSnapshot(
        boot="b",
        revision=24691,
        iteration=24691,
        t=1764040000.0,
        kernel=wire.Kernel(gamma=10.0),
        epsilon=0.1,
        C=1000.0,
        support=wire.Support(rate=(-0.2, 0.2), damping=(-80.0, 80.0), weight=(-90.0, 90.0)),
        inertia=350.0,
        effects=({"effect": "torque_lag"},),
        noise=3.9,
        trained_range=(-0.2, 0.2),
    )
    shown = text("vehicle/with/a/long/prefix/yaw", health, model)
    assert max(map(len, shown.splitlines())) <= WIDTH
    together = " ".join(re.sub(r"[!\n]", " ", shown).split())
    for words in (
        "WARN",
        "starved since 8.1 s",
        STARVED,
        "12345 clock jump",
        " 50 0.0 1764040000.0 ",
        "-0.0834 rad/s",
        "torque_lag",
    ):
        assert words in together
    assert "none yet" in text("leng/yaw", health, None)


def test_the_screen_is_in_the_words_and_units_of_the_axis(health: wire.Health) -> None:
    heave = text("leng/heave", health, None, axis=AXES["heave"])
    assert "heave velocity" in heave
    assert "-0.0834 m/s" in heave
    assert "force" in heave
    reply = wire.DampingReply(rate=(0.1,), damping=(2.0,), sigma=(0.3,), extrapolated=(False,), iteration=1, revision=1)
    head, row, _ = table(reply, AXES["heave"]).splitlines()
    assert head.split() == ["heave", "velocity", "[m/s]", "damping", "[N]", "±", "sigma", "[N]"]
    assert len(row) == len(head)
    head, row, _ = table(reply.model_copy(update={"derivative": (3.5,)}), AXES["heave"]).splitlines()
    assert head.endswith("derivative [N s/m]")
    assert row.split() == ["0.1000", "2.00", "0.30", "3.50"]


def test_an_iteration_is_one_line() -> None:
    nothing = wire.Points()
    report = wire.IterationReport(
        boot="b",
        revision=9999,
        iteration=9999,
        t=99999.4,
        time_span=(0.0, 1.0),
        trained=True,
        training_ms=1.0,
        counts={"new": 48, "forgotten": 29, "outliers": 9, "support": 60},
        old=nothing,
        new=nothing,
        support=nothing,
        forgotten=nothing,
        discarded_tube=nothing,
        discarded_near=nothing,
        outliers=nothing,
        progressive_mae=33.3,
    )
    assert len(iteration_line(report)) <= WIDTH
    assert iteration_line(report.model_copy(update={"change": "a hull"})).splitlines()[1].strip() == "a hull"


def asked(endpoint: str, capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    status = main(["status", "--connect", endpoint, *words])
    told = capsys.readouterr()
    return status, told.out, told.err


def test_status_is_one_where_nobody_answers(endpoint: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, error = asked(endpoint, capsys, "--wait", "0")
    assert (status, out) == (1, "")
    assert error.startswith(f"incsvr status: no bus answers at {endpoint}: start `incsvr serve`")
    assert main(["status", "--follow", "--connect", free_endpoint(), "--wait", "0"]) == 1


@pytest.mark.parametrize(
    ("rates", "beyond", "others", "axis", "sentence"),
    [
        ((0.1,), (False,), {}, "yaw", None),
        ((5.0,), (True,), {}, "yaw", "not learned there (up to 0.77 rad/s)"),
        ((-5.0, -1.0), (True, True), {}, "yaw", "not learned there (down to -0.75 rad/s)"),
        ((-5.0, 0.1, 5.0), (True, False, True), {}, "yaw", "not learned there (-0.75 to 0.77 rad/s): -5, 5 rad/s"),
        ((0.1,), (True,), {}, "yaw", "not learned there (-0.75 to 0.77 rad/s, with gaps)"),
        ((0.1,), (True,), {"surge": (2.0,)}, "yaw", "not learned there (-0.75 to 0.77 rad/s, among other velocities)"),
        ((5.0,), (True,), {}, "surge", "not learned there (up to 0.77 m/s)"),
    ],
)
def test_a_question_beyond_what_was_learned_gets_that_first(
    rates: tuple[float, ...], beyond: tuple[bool, ...], others: dict[str, tuple[float, ...]], axis: str, sentence: str
) -> None:
    zeros = (0.0,) * len(rates)
    reply = wire.DampingReply(
        rate=rates, damping=zeros, sigma=zeros, extrapolated=beyond, iteration=1, revision=1, others=others
    )
    assert not_learned(reply, (-0.75, 0.77), AXES[axis]) == sentence
    if any(beyond):
        assert (not_learned(reply, None) or "").startswith("not learned there")


@pytest.mark.slow
def test_status_tells_of_a_real_learner_and_follows_it(
    endpoint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    watch = subprocess.Popen(
        command("watch", "--connect", endpoint), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert watch.stderr is not None
    assert watch.stderr.readline().startswith("incsvr watch: use `incsvr status --follow`; ")
    assert "waiting for the bus: " in watch.stderr.readline()
    with client_after(endpoint, tmp_path) as (process, session, _):
        status, out, error = asked(endpoint, capsys, "--json", "-")
        found = json.loads(out)
        assert status == (0 if found["health"]["level"] == "OK" else 1)
        assert found["model"] is None
        assert "the first follows the first batch" in error

        lines: queue.Queue[str] = queue.Queue()
        assert watch.stdout is not None
        reader = threading.Thread(target=lambda out: deque(map(lines.put, out)), args=(watch.stdout,))
        reader.start()
        try:
            while "health is" not in lines.get(timeout=PATIENCE):
                pass
            models = following(session)
            teach(session, KEYS, 9, 0, 35)
            model = next_model(models)
            while not (line := lines.get(timeout=PATIENCE)).startswith("iteration 1, "):
                pass
            assert f"{len(model.support)} vectors" in line
            capsys.readouterr()
            assert main(["query", "5", "--connect", endpoint]) == 0
            first = capsys.readouterr().out.splitlines()[0]
            assert model.trained_range is not None
            assert first == f"not learned there (up to {model.trained_range[1]:.3g} rad/s)"
            watch.send_signal(signal.SIGINT)
            assert watch.wait(PATIENCE) == 0
        finally:
            watch.kill()
            watch.wait()
            reader.join()
            watch.stdout.close()
            watch.stderr.close()

        until = time.monotonic() + PATIENCE
        while (seen := asked(endpoint, capsys))[0] == 0:  # until the streams are silent for too long
            assert time.monotonic() < until
        assert "STALE" in seen[1]
        assert "revision 1, iteration 1" in seen[1]

        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) == 0
        assert process.stderr is not None
        told = process.stderr.read().decode()
    for words in (
        f"listens at {endpoint}",
        "receives leng/yaw/rate, leng/yaw/torque and leng/yaw/channel/*",
        f"keeps its state in {tmp_path}/leng/yaw.sqlite",
        "leng/yaw: iteration 1, ",
    ):
        assert words in told
