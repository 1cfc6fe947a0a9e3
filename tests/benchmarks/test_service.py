"""The studies of the service measure what they say: small runs of them, with real learners."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.service import bus, fleet, six_axes, soak
from benchmarks.service.hold import __main__ as hold
from benchmarks.service.hold import tracing_kills


@pytest.mark.slow
def test_what_is_sent_at_a_steady_pace_arrives_whole() -> None:
    found = bus._stream_at(pace=4000, size=10, seconds=0.5)
    assert found["lost"] == found["lost_as_health_says"] == 0
    assert found["samples_per_second_and_stream"] == pytest.approx(4000, rel=0.2)
    assert 20 < found["resident_mb"] < 500


@pytest.mark.slow
def test_the_learner_is_asked_in_turn_with_the_echo(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bus, "QUESTIONS", 200)
    found = bus.latency()
    for state in ("idle", "training"):
        for figure in ("p50", "p99"):
            both = found["query_us"][state][figure]
            assert both["ratio"] == pytest.approx(both["damping"] / both["echo"], rel=0.01)
            assert both["echo"] > 20.0
    assert found["query_us"]["iterations_per_second_while_training"] > 1.0


@pytest.mark.slow
def test_a_fleet_is_heard_ashore(tmp_path: Path) -> None:
    fleet.main(["--vehicles", "2", "--speed", "200", "--out", str(tmp_path)])
    result = json.loads((tmp_path / "fleet.json").read_text(encoding="utf-8"))
    assert min(result["iterations"]) >= fleet.ITERATIONS
    assert result["history"]["iterations"] == sum(result["iterations"])
    assert "| 2 learners, 14 iterations each: heard ashore |" in (tmp_path / "fleet.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_six_axes_are_learned_in_one_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(six_axes, "SETTLE_S", 1.0)
    six_axes.main(["--seconds", "4", "--hz", "20", "--out", str(tmp_path)])
    result = json.loads((tmp_path / "six_axes.json").read_text(encoding="utf-8"))
    assert (len(result["iterations"]), result["lost"], result["rejected"]) == (6, 0, 0)
    assert 0.5 < result["percent_of_a_core"] < 100.0
    assert 50.0 < result["peak_mb"] < 300.0


@pytest.mark.slow
def test_what_a_learner_survives(capsys: pytest.CaptureFixture[str]) -> None:
    hold.main(["--only", "kills", "junk", "--part", "0.005"])
    kills, junk = capsys.readouterr().out.splitlines()[-2:]
    assert kills.startswith("| kill -9 at a random moment, and a start | 1 | 0 | 0 |")
    assert junk.startswith("| junk on every key | 50 | 0 | 0 |")


@pytest.mark.slow
def test_a_tracing_process_that_is_killed_costs_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tracing_kills, "MAX_KILL_DELAY_S", 1.0)
    hold.main(["--only", "tracing", "--part", "0.04"])
    row = capsys.readouterr().out.splitlines()[-1]
    assert row.startswith("| the tracing process killed at a random moment | 2 | 0 | 0 |")


@pytest.mark.slow
def test_a_soak_sees_nothing_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(soak, "LOOK_PERIOD_S", 0.5)
    soak.main(["--minutes", "0.08", "--out", str(tmp_path)])
    result = json.loads((tmp_path / "soak.json").read_text(encoding="utf-8"))
    assert result["iterations"] > 3
    assert result["counters"]["rejected"] == 0
