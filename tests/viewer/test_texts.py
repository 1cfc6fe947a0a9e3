"""What the viewer says in words: the table, health, the ledger of effects."""

from __future__ import annotations

import pytest

from service.wire import EffectsLedger, Health, StreamHealth
from tests.viewer.conftest import Run
from viewer.effects import ledger_text
from viewer.frame import Frame, clock_text
from viewer.health import health_text
from viewer.table import headline, quantity, table

LAG = {
    "effect": "torque_lag",
    "channels": ["torque"],
    "parameters": {"time_constant_s": 0.71},
    "interval": {"time_constant_s": [0.66, 0.76]},
    "p_value": 1e-6,
    "share": 0.88,
    "sentence": "The torque arrives 0.71 s late.",
}


def test_the_table_has_every_count_and_figure(run: Run) -> None:
    report, snapshot = run.iterations[3]
    text = table(Frame(report, snapshot, None))
    for words in (
        f"# Iteration {report.iteration} ",
        f"50 samples, vehicle time {report.time_span[0]:.1f} s",
        f"revision {report.revision}",
        f"| New samples | {len(report.new)} |",
        f"| Discarded, near a vector | {len(report.discarded_near)} |",
        f"| Training time | {report.training_ms:.1f} ms |",
        f"| Off the optimum at most | {quantity(report.certified_error, 'N m')} |",
    ):
        assert words in text


def test_the_headline_is_the_error_on_what_was_new(run: Run) -> None:
    first, later = (Frame(*run.iterations[k], None) for k in (0, 4))
    assert headline(first) == "first model"
    assert headline(later) == f"error {quantity(later.report.progressive_mae, 'N m')}"


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "-"), (3.14159, "3.14 N m"), (0.0000849, "0.0000849 N m"), (0.0, "0 N m"), (123.4, "123 N m")],
)
def test_a_quantity_is_never_a_power_of_ten(value: float | None, text: str) -> None:
    assert quantity(value, "N m") == text


def test_the_vehicles_time_is_a_date_where_it_counts_from_1970() -> None:
    assert clock_text(812.44) == "812.4 s"
    assert clock_text(1.7e9).startswith("2023-11-")


def test_health_says_the_level_then_why_then_the_counters() -> None:
    health = Health(
        level="WARN",
        reasons=("the last torque came 3.2 s ago",),
        counters={"rejected:late": 4},
        learned=0.87,
        boot="abc",
        streams={"torque": StreamHealth(received=100, lost=2, t=5.0)},
    )
    lines = health_text(health).splitlines()
    assert lines[0] == "# WARNING"
    assert lines[1] == "- The last torque came 3.2 s ago."
    assert "| rejected: late | 4 |" in lines
    assert "| torque | 100 | 2 | 5.0 s |" in lines
    assert any("Learned: 87 %" in line for line in lines)


def test_the_ledger_tells_each_effect_and_each_step() -> None:
    text = ledger_text(
        EffectsLedger(effects=(LAG,), history=({"t": 812.4, "step": "promoted", "effect": "torque_lag"},))
    )
    assert "## torque lag" in text
    assert "The torque arrives 0.71 s late." in text
    assert "- time_constant_s: 0.71 (0.66 to 0.76)" in text
    assert "- 88 % of what could be explained, p = 1e-06" in text
    assert "| 812.4 | promoted | torque_lag |" in text
    assert "p < 1e-300" in ledger_text(EffectsLedger(effects=({**LAG, "p_value": 0.0},)))
    assert "None:" in ledger_text(EffectsLedger())
