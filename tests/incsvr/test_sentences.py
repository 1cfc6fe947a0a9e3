"""What a finding says to people."""

from __future__ import annotations

from incsvr.effects import catalogue
from incsvr.tracing.sentences import sentence


def test_a_negative_delay_is_no_dead_time() -> None:
    delay = catalogue()["torque_delay"]
    late, ahead = (sentence(delay, {"delay_s": value}, {"delay_s": (value, value)}, 0.5) for value in (0.3, -0.3))
    assert "dead time" in late
    assert "dead time" not in ahead
    assert "stamps are late" in ahead
