"""The confusion matrix: its judge, its cases, its peers, and a small one made with the real tracer."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.tracer import innovation_peers as peers
from benchmarks.tracer.judge import interval, judge
from benchmarks.tracer.trace_cases import AUTOCORRELATIONS, GROUPS, KINDS, case
from benchmarks.tracer.trace_table import TABLES, add_arguments, as_run, examine, run, torque_kind
from simulator.effects import EFFECTS
from simulator.trial import Trial, play
from simulator.trial_command import EXCITATIONS


@pytest.mark.parametrize(
    ("hidden", "named", "verdict"),
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
        (("drag_step", "wave"), {"wave": ("drag_step",)}, "joint"),
        (("drag_step", "wave"), {"wave": ("drag_step",), "tether": ()}, "false"),
        (("coupling:sway",), {"coupling:surge": ()}, "both"),
    ],
)
def test_the_judge(hidden: tuple[str, ...], named: dict[str, tuple[str, ...]], verdict: str) -> None:
    assert judge(hidden, named) == verdict


def test_wilsons_interval() -> None:
    # Newcombe 1998, Table I, method 3: 81/263 and 0/20.
    assert interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert interval(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)


def test_the_cases_cover_every_effect_in_every_excitation_and_every_colour() -> None:
    one = [case("one", index, 0) for index in range(len(KINDS) * len(EXCITATIONS))]
    covered = {(trial.effects[0].partition(":")[0], trial.excitation) for trial in one}
    assert covered == {(kind, excitation) for kind in KINDS for excitation in EXCITATIONS}
    assert set(EFFECTS) < set(KINDS)
    assert {trial.vehicle for trial in one} == {"leng", "small"}
    quiet = [case("quiet", index, 0) for index in range(48)]
    assert {(trial.autocorrelation, trial.excitation) for trial in quiet} == {
        (colour, excitation) for colour in AUTOCORRELATIONS for excitation in EXCITATIONS
    }
    for index in range(60):
        assert len(set(case("two", index, 0).effects)) == 2
        half = case("half", index, 0)
        assert half.size == 0.5
        assert half.effects == case("one", index, 0).effects


def test_a_peer_sees_a_strong_effect_and_names_others_beside_it() -> None:
    outcome = play(Trial(seed=5, effects=("coupling:sway",), excitation="multisine", duration=240.0))
    problem = peers.terms(as_run(outcome), outcome.inertia)
    np.testing.assert_allclose(np.std(problem.columns, axis=0), 1.0, rtol=0.2)
    for select in peers.PEERS.values():
        named = peers.answer(problem, select(problem))
        assert "coupling:sway" in named
        assert set(named) <= set(problem.names)


def test_the_real_tracer_finds_what_is_hidden_and_nothing_where_nothing_is() -> None:
    for effects in (("coupling:sway",), ()):
        trial = Trial(seed=41, effects=effects, excitation="multisine", duration=300.0)
        record = examine("one" if effects else "quiet", trial, in_depth=False, told=True)
        assert record["failure"] is None
        assert record["judged"] in ("right", "class"), record["named"]


def test_a_small_table_is_written_with_command_and_date(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    counts = ["--one", "1", "--half", "0", "--two", "0", "--quiet", "1", "--deep-every", "2"]
    args = parser.parse_args(
        [*counts, "--processes", "1", "--first-seed", "50", "--minutes", "2", "--out", str(tmp_path)]
    )
    assert run(args) == 0
    document = json.loads((tmp_path / "trace_table.json").read_text(encoding="utf-8"))
    assert [record["group"] for record in document["records"]] == ["one", "quiet"]
    assert [record["seed"] for record in document["records"]] == [50, 50]
    text = (tmp_path / "trace_table.md").read_text(encoding="utf-8")
    assert document["date"] in text
    assert document["command"] in text
    for heading in ("False alarms with nothing hidden", GROUPS["one"].capitalize()):
        assert f"## {heading}" in text
    for name in peers.PEERS:
        assert name in text
    assert "a torque that is the command" in text
    assert text.strip() == capsys.readouterr().out.strip()


def test_each_kind_of_noise_has_a_table_of_its_own_and_only_commands_are_told_to_be_commands() -> None:
    assert len(set(TABLES.values())) == len(TABLES) == 3
    assert {noise: torque_kind(noise) for noise in TABLES} == {
        "commanded": "commanded",
        "measured": "measured",
        "torque": "measured",
    }
