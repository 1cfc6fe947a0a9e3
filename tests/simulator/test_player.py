"""What the player sends, and when."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import numpy as np
import pytest
import zenoh

from service import wire
from service.bus.session import client_config_at, free_endpoint, listener_config_at, open_session
from service.cli.command_line import main
from service.recordings.reading import read
from simulator.messages import messages
from simulator.player import play

KEYS = wire.Keys("leng/yaw")
STREAMS = {
    "yaw_rate": (np.arange(0.0, 2.0, 0.02), np.linspace(-0.1, 0.1, 100)),
    "torque": (np.arange(0.005, 2.0, 0.04), np.linspace(10.0, 20.0, 50)),
    "depth": (np.array([0.5]), np.array([3.0])),
}


def test_every_value_is_sent_once_at_its_time() -> None:
    what = messages(STREAMS)
    assert len(what) == 151
    assert (what.send == what.t).all()
    assert (np.diff(what.send) >= 0.0).all()
    for number, (t, value) in enumerate(STREAMS.values()):
        np.testing.assert_array_equal(what.t[what.stream == number], t)
        np.testing.assert_array_equal(what.value[what.stream == number], value)


def test_the_player_keeps_the_pace_and_numbers_its_messages() -> None:
    endpoint = free_endpoint()
    taken: dict[str, list[tuple[float, wire.Measurement]]] = {}
    with open_session(listener_config_at(endpoint)) as bus, open_session(client_config_at(endpoint), 5.0) as session:

        def take(sample: zenoh.Sample) -> None:
            form = wire.decode(wire.Measurement, sample.payload.to_bytes())
            taken.setdefault(str(sample.key_expr), []).append((time.monotonic(), form))

        bus.declare_subscriber("leng/yaw/**", take)
        asked = threading.Event()

        def answer(query: zenoh.Query) -> None:
            received = {name: len(taken.get(KEYS.stream(name), ())) for name in ("yaw_rate", "torque")}
            streams = {name: wire.StreamHealth(received=count) for name, count in received.items()}
            query.reply(KEYS.health, wire.encode(wire.Health(level="OK", boot="test", streams=streams)))
            asked.set()

        bus.declare_queryable(KEYS.health, answer)
        began = time.monotonic()
        assert play(session, KEYS, messages(STREAMS), speed=4.0, stop=threading.Event()) == 151
        assert time.monotonic() - began >= 1.98 / 4.0
        assert asked.is_set()
    assert {key: len(found) for key, found in taken.items()} == {
        KEYS.rate: 100,
        KEYS.torque: 50,
        KEYS.stream("depth"): 1,
    }
    assert [form.seq for _, form in taken[KEYS.rate]] == list(range(100))
    arrived = np.array([at for at, _ in taken[KEYS.rate]]) - began
    due = np.array([form.t for _, form in taken[KEYS.rate]]) / 4.0
    assert (arrived >= due - 1e-3).all()


def test_the_stop_is_heard() -> None:
    endpoint = free_endpoint()
    stop = threading.Event()
    with open_session(listener_config_at(endpoint)), open_session(client_config_at(endpoint), 5.0) as session:
        sent = play(session, KEYS, messages(STREAMS), speed=1.0, stop=stop, second=stop.set)
    assert sent < 151


def test_the_experiment_is_written_as_recordings(tmp_path: Path) -> None:
    words = ["simulate", "--runs", "V2", "--seed", "3", "--write", str(tmp_path)]
    assert main(words) == 0
    recording = read(tmp_path / "V2.csv")
    assert recording.time[-1] > 290.0
    assert set(recording.columns) == {"yaw_rate", "torque"}


@pytest.mark.parametrize("speed", ["0", "-1", "nan", "inf"])
def test_a_speed_that_is_none_is_refused(speed: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", f"--speed={speed}"]) == 2
    assert "give a positive number" in capsys.readouterr().err


@pytest.mark.parametrize("flag", ["--seed=-1", "--underway=-1"])
def test_a_seed_that_there_is_not_is_refused(flag: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", flag]) == 2
    assert "give a number from 0 to" in capsys.readouterr().err
