"""The table of the grid search over seeds."""

from __future__ import annotations

from benchmarks.paper.repetition import LEARNERS
from benchmarks.paper.tuning import report
from incsvr.learning.tuning import Grid, search
from tests.incsvr.learning import stream


def test_the_table_tells_who_won_and_where_the_papers_point_stands() -> None:
    grid = Grid(C=(0.1, 1000.0), epsilon=(0.1, 80.0), gamma=(10.0,))
    found = [list(search(stream(seed, 200), LEARNERS["paper"], grid)) for seed in (1, 2)]
    lines = report(found, "a command, a date").splitlines()
    assert sum("the paper's point ranks 1 to 1, 1 in the median" in line for line in lines) == 2
    assert sum("Chosen: {1000, 0.1, 10} in 2 of 2." in line for line in lines) == 2
    rows = [line for line in lines if line.startswith("|")][2:]
    assert len(rows) == 4
    assert "← the paper's" in rows[0]
    assert rows[0].startswith("| 1000 | 0.1 | 10 |")
