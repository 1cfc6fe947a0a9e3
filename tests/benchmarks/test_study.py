"""What studies share: options and provenance, processes, pages, tables and intervals."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from benchmarks.study import begin, grouped, in_processes, interval, options, publish, table
from benchmarks.tables import counted, page, share


def twice(number: int) -> int:
    return 2 * number


def late(seconds: float) -> float:
    time.sleep(seconds)
    return seconds


def test_a_study_knows_the_command_that_makes_it_anew(tmp_path: Path) -> None:
    parser = options("benchmarks.room.name", "What it is.", seeds=(20, "logs"), first_seed=(7, "of them"))
    args, measured = begin(parser, ["--seeds", "3", "--out", str(tmp_path)])
    assert (args.seeds, args.first_seed, args.out) == (3, 7, tmp_path)
    assert measured["command"] == f"python -m benchmarks.room.name --seeds 3 --out {tmp_path}"
    assert {"numpy", "scipy"} == set(measured["versions"])


@pytest.mark.parametrize("processes", [1, 2])
def test_results_come_in_the_order_of_their_cases(processes: int) -> None:
    # Functions that the processes can import wherever they are started.
    assert in_processes(str, range(7), "numbers", processes) == ["0", "1", "2", "3", "4", "5", "6"]
    assert in_processes(eval, ["__import__('time').sleep(0.2) or 1", "2", "3"], "waits", processes) == [1, 2, 3]


def test_no_case_begins_after_its_time() -> None:
    assert in_processes(late, [0.2, 0.0, 0.0], "waits", 1, minutes=0.1 / 60.0) == [0.2]
    assert in_processes(twice, range(3), "numbers", 2, minutes=0.0) == []


def test_a_study_is_written_and_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = page("# A page", "", table(["a", "b"], [[1, "x"]]))
    publish(tmp_path / "new", "name", {"figure": float("nan")}, text)
    assert (tmp_path / "new" / "name.md").read_text(encoding="utf-8") == text == capsys.readouterr().out
    assert text == "# A page\n\n| a | b |\n| --- | --- |\n| 1 | x |\n"
    assert "null" in (tmp_path / "new" / "name.json").read_text(encoding="utf-8")


def test_wilsons_interval() -> None:
    # Newcombe 1998, Table I, method 3: 81/263 and 0/20.
    assert interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert interval(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert share(81, 263) == "30.8 % (26–37)"
    assert share(0, 0) == "–"


def test_records_are_grouped_in_their_order() -> None:
    records = [{"a": 2, "b": 1}, {"a": 1, "b": 2}, {"a": 2, "b": 3}]
    assert list(grouped(records, "a").items()) == [(2, [records[0], records[2]]), (1, [records[1]])]
    assert counted({"x": 1, "y": 3, "z": 0}) == "y 3, x 1"
    assert counted({}) == "–"
