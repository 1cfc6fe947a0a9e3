"""The study of p-values: every effect of the catalogue is asked, and the table counts what lies below a level."""

from __future__ import annotations

from benchmarks.calibration import examine, rows
from incsvr.effects import candidates


def test_every_effect_of_a_log_in_which_nothing_is_hidden_gets_a_p_value() -> None:
    found = examine((1, "multisine", 0.5))
    assert [record["effect"] for record in found] == [effect.key for effect in candidates([])]
    assert all(0.0 <= record["p"] <= 1.0 for record in found)
    assert sum(record["p"] < 0.01 for record in found) <= 3


def test_a_row_counts_what_is_below_each_level() -> None:
    records = [{"effect": "inertia", "p": p} for p in (0.5, 0.04, 0.004, 1e-5)]
    *_, row = rows(records, "effect")
    assert row.startswith("| inertia | 4 | 75.0 % (")
    assert " | 50.0 % (" in row
    assert row.count("25.0 % (") == 1
