"""The frame of every study: options, cases in processes, its page."""

from __future__ import annotations

import argparse
import json
import operator
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from benchmarks.study import interval, run, seeds, share, table


def page(results: Sequence[int]) -> Iterator[str]:
    yield ""
    yield table(["seed, negative"], [[result] for result in results])


@pytest.mark.parametrize("processes", [1, 2])
def test_a_study_writes_its_results_in_order_with_the_command_that_repeats_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], processes: int
) -> None:
    words = ["--seeds", "3", "--processes", str(processes), "--out", str(tmp_path / "new")]
    run("negatives", "Numbers, negative.\n\nMore.", seeds, operator.neg, page, words, seeds=(20, "numbers"),
        first_seed=(7, "of them"))  # fmt: skip
    document = json.loads((tmp_path / "new" / "negatives.json").read_text(encoding="utf-8"))
    assert document["results"] == [-7, -8, -9]
    assert document["command"] == f"python -m benchmarks.negatives {' '.join(words)}"
    text = (tmp_path / "new" / "negatives.md").read_text(encoding="utf-8")
    assert text == capsys.readouterr().out
    assert text.startswith(f"# Numbers, negative\n\n`{document['command']}`, {document['date']}, ")
    assert text.endswith(".\n\n| seed, negative |\n| --- |\n| -7 |\n| -8 |\n| -9 |\n")


def test_without_a_case_nothing_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def none(asked: argparse.Namespace) -> list[int]:
        return []

    with pytest.raises(SystemExit) as end:
        run("negatives", "Numbers.", none, operator.neg, page, ["--out", str(tmp_path)])
    assert end.value.code == 2
    assert "nothing to examine" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_wilsons_interval() -> None:
    # Newcombe 1998, Table I, method 3: 81/263 and 0/20.
    assert interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert interval(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert share(81, 263) == "81 of 263 (26–37 %)"
    assert share(0, 0) == "–"
