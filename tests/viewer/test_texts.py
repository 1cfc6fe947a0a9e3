"""What the viewer says in words: the table, health, the ledger of effects."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.tracing.sentences import LABELS
from service.wire import EffectsLedger, Health, StreamHealth
from tests.viewer.conftest import Run
from viewer import names
from viewer.effects import ledger_text
from viewer.frame import Frame, clock_text
from viewer.health import axes_text
from viewer.pauses import Pauses
from viewer.table import quantity, samples_table, table

LAG = {
    "effect": "torque_lag",
    "channels": ["torque"],
    "parameters": {"time_constant_s": 0.71},
    "interval": {"time_constant_s": [0.66, 0.76]},
    "p_value": 1e-6,
    "share": 0.88,
    "sentence": "The torque arrives 0.71 s late.",
}


def test_the_tables_have_the_figures_of_the_iteration(run: Run) -> None:
    report, snapshot = run.iterations[3]
    frame = Frame(report, snapshot, None)
    text = table(frame) + samples_table(frame)
    for words in (
        f"# Iteration {report.iteration}  ·  error {quantity(report.progressive_mae, 'N m')}",
        f"revision {report.revision}",
        f"| Discarded, near a vector | {len(report.discarded_near)} |",
        f"| Off the optimum at most | {quantity(report.certified_error, 'N m')} |",
    ):
        assert words in text


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "-"), (3.14159, "3.14 N m"), (0.0000849, "0.0000849 N m"), (0.0, "0 N m"), (123.4, "123 N m")],
)
def test_a_quantity_is_never_a_power_of_ten(value: float | None, text: str) -> None:
    assert quantity(value, "N m") == text


def test_the_vehicles_time_is_a_date_where_it_counts_from_1970() -> None:
    assert clock_text(812.44) == "812.4 s"
    assert clock_text(1.7e9).startswith("2023-11-")


def test_each_axis_of_a_vehicle_has_a_line() -> None:
    streams = {"yaw_rate": StreamHealth(received=3, value=0.62)}
    surge = Health(level="STALE", boot="abc", revision=7, learned=0.5, streams=streams)
    lines = axes_text("rov", {"yaw": Health(level="OK", boot="abc"), "surge": surge}).splitlines()
    assert lines[0] == "# rov"
    assert lines[-2:] == [
        "| yaw | OK | learning | - | 0 | 0 % |",
        "| surge | NO DATA | learning | 0.62 m/s | 7 | 50 % |",
    ]


def test_the_ledger_tells_each_effect_and_each_step() -> None:
    text = ledger_text(
        EffectsLedger(effects=(LAG,), history=({"t": 812.4, "step": "promoted", "effect": "torque_lag"},))
    )
    for line in ("## Torque lag", "- Time constant 0.71 s (0.66 to 0.76)", "- **812.4 s** Torque lag: promoted"):
        assert line in text


def test_people_read_names_and_units_and_never_a_key() -> None:
    assert names.effect("coupling:thruster_3_speed") == "Coupling to thruster 3 speed"
    assert names.channel("thruster_3_pwm") == "Thruster 3 pwm [µs]"
    step = {"t": 3.0, "step": "suspected", "effect": "torque_lag", "why": "torque_lag: it lags", "revision": 7}
    assert names.step(step) == "**3.0 s** Torque lag: suspected: it lags (revision 7)"
    for key in LABELS:
        assert not set("_{}") & set(names.parameter(key, 1.0)), key


@pytest.mark.parametrize("cut", [1, 7, 100, 151])
def test_a_line_ends_where_a_pause_begins(cut: int) -> None:
    """However the stream comes in pieces; a slow stream has no pauses of its own."""
    time = np.concatenate((np.arange(0.0, 10.0, 0.1), np.arange(20.0, 30.0, 0.1)))
    pauses, pieces = Pauses(), np.split(time, range(cut, time.size, cut))
    drawn = np.concatenate([np.column_stack(pauses.broken(piece, np.sin(piece))) for piece in pieces])
    ends = drawn[np.isnan(drawn[:, 1]), 0]
    assert ends == pytest.approx([9.9], abs=0.01)
    assert drawn[~np.isnan(drawn[:, 1]), 0] == pytest.approx(time)
    assert np.all(np.diff(drawn[:, 0]) >= 0.0)
    slow = Pauses()
    assert not any(np.isnan(slow.broken(np.array([4.0 * k]), np.zeros(1))[1]).any() for k in range(20))
