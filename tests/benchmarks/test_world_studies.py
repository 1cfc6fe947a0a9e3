"""The studies over the simulated world: the judge, and a small run of each."""

from __future__ import annotations

import json
from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks import control, live, missions, trace, whole_vehicle
from benchmarks.study import run
from simulator.mission import EFFECTS, LISTS, ON_CHANNEL


@pytest.mark.parametrize(
    ("sought", "named", "verdict"),
    [
        ((), {}, "right"),
        ((), {"inflow": ()}, "false"),
        (("wave",), {"wave": ("tether",)}, "right"),
        (("wave",), {}, "missed"),
        (("wave",), {"tether": ()}, "both"),
        (("torque_lag",), {"torque_delay": ("torque_lag",)}, "class"),
        (("torque_lag",), {"torque_lag": (), "torque_delay": ("torque_lag",)}, "false"),
        (("torque_lag", "wave"), {"torque_delay": ("torque_lag",)}, "missed"),
        (("torque_lag", "wave"), {"wave": (), "torque_delay": ("torque_lag",)}, "class"),
        # One named effect cannot stand for two hidden ones, nor beside itself for another, but as both at once.
        (("drag_step", "drag_drift"), {"memory": ("drag_step", "drag_drift")}, "joint"),
        (("drag_step", "wave"), {"wave": ("drag_step",), "tether": ()}, "false"),
        (("coupling:sway",), {"coupling:surge": ()}, "both"),
    ],
)
def test_the_judge(sought: tuple[str, ...], named: dict[str, tuple[str, ...]], verdict: str) -> None:
    assert trace.judge(sought, named) == verdict


def test_the_cases_hide_every_effect_of_both_lists() -> None:
    asked = Namespace(first_seed=1, one=18, half=0, two=4, quiet=2)
    played = [(case, trace.mission(case)) for case in trace.cases(asked)]
    for of in LISTS:
        single = {m.hidden[0].partition(":")[0] for case, m in played if (case.of, case.group) == (of, "one")}
        assert single == {*EFFECTS, *ON_CHANNEL}
    for case, mission in played:
        assert len(mission.hidden) == {"one": 1, "two": 2, "quiet": 0}[case.group]
        assert {name.partition(":")[2] for name in mission.hidden} - {""} <= {*mission.channels}


def test_a_live_mission_with_an_effect_is_its_twin_in_everything_else() -> None:
    loud = live.drawn(live.Case(7, True, 3600.0))
    assert replace(loud, hidden=()) == live.drawn(live.Case(7, False, 3600.0))
    assert 1200.0 <= loud.onset <= 2400.0


def results(module: Any, folder: Path, cases: list[Any]) -> list[dict[str, Any]]:
    """What a study of these cases writes; its page names the command."""
    name = module.__name__.rpartition(".")[2]
    run(name, module.__doc__, lambda _: cases, module.examine, module.report, ["--out", str(folder)])
    assert f"python -m benchmarks.{name}" in (folder / f"{name}.md").read_text(encoding="utf-8")
    found: list[dict[str, Any]] = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))["results"]
    return found


@pytest.mark.slow
def test_the_study_of_hidden_effects(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def short(case: trace.Case, whole: Any = trace.mission) -> Any:
        return whole(case, 300.0)

    monkeypatch.setattr(trace, "mission", short)
    cases = [trace.Case("main", "command", "one", 0, 5), trace.Case("second", "measured", "quiet", 0, 5)]
    one, quiet = results(trace, tmp_path, cases)
    assert one["hidden"] == ["bias_torque"]
    assert one["judged"] in trace.GOOD
    assert quiet["named"] == {}


@pytest.mark.slow
def test_the_study_of_missions(tmp_path: Path) -> None:
    cases = [missions.Case(kind, "auv", 3, 400.0) for kind in ("rate_control", "station")]
    driven, still = results(missions, tmp_path, cases)
    assert driven["paper"]["near"] > 0.9
    assert driven["weighted"]["near"] > 0.9
    assert driven["named"] == {}
    assert "too little motion" in still["refused"]


@pytest.mark.slow
def test_the_study_of_live_tracing(tmp_path: Path) -> None:
    (found,) = results(live, tmp_path, [live.Case(930_003, True, 1500.0)])
    assert found["effect"] == "torque_delay"
    assert "suspected" in [step for _, step, _ in found["steps"]]


@pytest.mark.slow
def test_the_study_of_whole_vehicles(tmp_path: Path) -> None:
    (found,) = results(whole_vehicle, tmp_path, [("still water", "torpedo", 3, 120.0)])
    rows = [row for row in found["rows"] if row["parameter"] == "inertia"]
    assert len(rows) == 3
    assert all(row["ratio"] == pytest.approx(1.0, abs=0.05) for row in rows)


@pytest.mark.slow
def test_the_study_of_control(tmp_path: Path) -> None:
    cases = [("feed-forward", "bias_torque", 5, 200.0), ("forecast", "waypoints", 5, 600.0)]
    helped, forecast = results(control, tmp_path, cases)
    assert helped["found"] == ["bias_torque"]
    assert helped["with"] < 0.5 * helped["alone"]
    inside = [abs(error) <= half for _, error, half, _ in forecast["forecasts"]]
    assert sum(inside) >= 0.8 * len(inside) > 0
