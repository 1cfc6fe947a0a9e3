"""The bus's benchmark measures what it says: small runs of it, with a real learner."""

from __future__ import annotations

import pytest

from benchmarks.service import bus


def test_what_is_sent_at_a_steady_pace_arrives_whole() -> None:
    found = bus._stream_at(pace=4000, size=10, seconds=0.5)
    assert found["lost"] == found["lost_as_health_says"] == 0
    assert found["samples_per_second_and_stream"] == pytest.approx(4000, rel=0.2)
    assert 20 < found["resident_mb"] < 500


def test_the_learner_is_asked_in_turn_with_the_echo(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bus, "QUESTIONS", 200)
    found = bus.latency()
    for state in ("idle", "training"):
        for figure in ("p50", "p99"):
            both = found["query_us"][state][figure]
            assert both["ratio"] == pytest.approx(both["damping"] / both["echo"], rel=0.01)
            assert both["echo"] > 20.0
    assert found["query_us"]["iterations_per_second_while_training"] > 1.0
