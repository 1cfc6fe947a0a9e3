"""`incsvr compare --from-learner`: a line for each dive in a learner's state, compared without logs."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from service.cli.command_line import main
from service.config.configuration import Config
from service.config.vehicle import Vehicle
from service.host.persist_then_publish import DIVES_KEY
from service.learner.dives import MAX_PAUSE_S, DiveLine, Dives
from service.state.store import Store
from tests.service.state.iterations import outcomes

DRAGS = (80.0, 82.0, 81.0, 80.5, 94.0, 93.0)
"""The drags of six dives [N m]: the drag grows by a sixth in the fifth."""
LINE = DiveLine("yaw", "b", 0.0, 400.0, 400.0, 400.0, 600, 0.15, [], "drag", 0.125, 0.0, 1.7, 24)


def write_state(folder: Path, lines: list[DiveLine], prefix: str = "leng/yaw") -> None:
    store = Store(folder, Config(prefix=prefix))
    dives = Dives(Vehicle(), [line_dict(line) for line in lines])
    store.save_memory({"revision": 0, DIVES_KEY: dives.to_list()})
    store.close()


def line_dict(line: DiveLine) -> dict[str, Any]:
    return {name: getattr(line, name) for name in line.__slots__}


def of_days(drags: tuple[float, ...]) -> list[DiveLine]:
    """A dive a day."""
    return [replace(LINE, began=86_400.0 * (20_000 + day), estimate=drag) for day, drag in enumerate(drags)]


def test_a_start_a_long_pause_and_stamps_that_begin_anew_begin_a_dive() -> None:
    first, second, third = outcomes()
    dives = Dives(Vehicle())
    for now, outcome in ((10.0, first), (40.0, second), (41.0, second)):  # the second is learned again
        dives.add(outcome.report, outcome.snapshot.model(), (), now)
    model = third.snapshot.model()
    (line,) = dives.to_list()
    assert (line["began"], line["ended"], line["boot"]) == (10.0, 41.0, "b")
    assert line["seconds"] == pytest.approx(second.report.t - first.report.batch.time[0])
    assert line["at_speed"] == 0.125
    said = model.predict((0.125, -0.125))
    for update, count in (
        ({}, 1),
        ({"t": third.report.t + MAX_PAUSE_S - 1.0}, 1),
        ({"t": third.report.t + 3.0 * MAX_PAUSE_S}, 2),
        ({"t": 5.0}, 3),
        ({"t": 9.0, "boot": "c"}, 4),
    ):
        dives.add(third.report.model_copy(update=update), model, ({"effect": "coulomb"},), 70.0)
        assert len(dives.to_list()) == count, update
    newest = dives.to_list()[-1]
    assert newest["estimate"] == pytest.approx(0.5 * (said.damping[0] - said.damping[1]))
    assert newest["standard_error"] == pytest.approx(0.5 * float((said.doubt**2).sum()) ** 0.5)
    assert (newest["effects"], newest["quantity"]) == (["coulomb"], "drag")


def test_the_dive_of_a_change_is_found_in_a_state(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_state(tmp_path, [replace(LINE, estimate=60.0, effects=["coulomb"]), *of_days(DRAGS)])
    target = tmp_path / "compared.json"
    assert main(["compare", "--from-learner", str(tmp_path), "--json", str(target)]) == 0
    found = json.loads(target.read_text(encoding="utf-8"))
    assert [row["estimate"] for row in found["rows"]] == list(DRAGS)
    assert [row["dive"] for row in found["rows"] if row["changed"]] == ["2024-10-08 00:00:00"]
    assert "1 dives are left out" in found["left_out"][0]
    told = capsys.readouterr().out
    assert "2024-10-08 00:00:00: leng yaw drag changed by +16 % from this dive on (95 %: +11 to +21 %; p = " in told
    pytest.importorskip("pyarrow", reason="the extra logs is not installed")
    table = tmp_path / "history.parquet"
    assert main(["compare", "--from-learner", str(tmp_path), "--table", str(table)]) == 0
    assert main(["compare", str(table), "--json", str(target)]) == 0  # the table of a fleet
    (change,) = json.loads(target.read_text(encoding="utf-8"))["changes"]
    assert (change["vehicle"], change["dive"], change["quantity"]) == ("leng", "2024-10-08 00:00:00", "drag")


def test_unchanged_dives_and_states_that_hold_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_state(tmp_path, of_days(DRAGS[:4]))
    assert main(["compare", "--from-learner", str(tmp_path)]) == 0
    assert "no change" in capsys.readouterr().out
    empty, damaged = tmp_path / "empty", tmp_path / "damaged"
    write_state(empty, [])
    damaged.mkdir()
    (damaged / "yaw.sqlite").write_bytes(b"no state")
    for path, why in ((empty, "no dive was learned"), (damaged, "cannot be read"), (tmp_path / "none", "cannot be")):
        assert main(["compare", "--from-learner", str(path)]) == 2
        assert why in capsys.readouterr().err
    assert main(["compare"]) == 2
