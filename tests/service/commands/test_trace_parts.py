"""The part after a step is traced by itself: what it shows stands in the text, the JSON and the report."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.tracing import trace
from incsvr.tracing.findings import Finding, Trace
from service.cli.command_line import main
from service.commands.trace import runs_of
from service.commands.trace_parts import after_steps
from service.recordings.recording import Recording
from service.recordings.recording_csv import write

HULL = 300.0
"""A hull is mounted then [s]."""
STEP = 0.05


def dive(seconds: float = 600.0, *, hull: float = 2.2) -> Recording:
    """A vehicle of 350 kg m² under held torques; from HULL on its damping is `hull` times what it was."""
    random = np.random.default_rng(7)
    count = round(seconds / STEP)
    time = STEP * np.arange(count, dtype=np.float64)
    torque = np.repeat(random.uniform(-60.0, 60.0, count // 60 + 1), 60)[:count]
    rate, now, fine = np.zeros(count), 0.0, 10
    for k in range(count):
        rate[k] = now
        damped = hull if time[k] >= HULL else 1.0
        for _ in range(fine):
            now += STEP / fine * (torque[k] - damped * (120.0 * now + 700.0 * now * abs(now))) / 350.0
    return Recording("hull", time, {"yaw_rate": rate + random.normal(0.0, 2e-4, count), "torque": torque})


@pytest.fixture(scope="module")
def recording() -> Recording:
    return dive()


@pytest.fixture(scope="module")
def plain(recording: Recording) -> Trace:
    """The trace of the part before the hull, for a result whose findings tests put in."""
    kept = recording.time < HULL
    columns = {name: values[kept] for name, values in recording.columns.items()}
    return trace(runs_of([replace(recording, time=recording.time[kept], columns=columns)]), inertia=350.0)


def stepping(effect: str, at: float, low: float | None = None, high: float | None = None) -> Finding:
    ends = (at if low is None else low, at if high is None else high)
    return Finding(effect, ("t",), {"fraction": 1.0, "at_s": at}, {"at_s": ends}, 1e-9, 0.5, (), "", effect)


def spans(found: Trace, recording: Recording, *findings: Finding) -> list[tuple[tuple[str, ...], float, float]]:
    """The parts after these steps, and that exactly they were traced."""
    seen: list[tuple[float, float]] = []

    def traced(part: Sequence[Recording]) -> Trace:
        seen.append((float(part[0].time[0]), float(part[-1].time[-1])))
        return found

    parts = after_steps(replace(found, effects=findings), [recording], traced)
    for part, (first, last) in zip(parts, seen, strict=True):
        assert part.begin <= first < part.begin + STEP + 1e-9
        assert last < part.end
    return [(part.after, part.begin, part.end) for part in parts]


@pytest.mark.slow
def test_the_command_says_what_the_part_shows(
    recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, report = tmp_path / "hull.csv", tmp_path / "hull.html"
    write(path, recording)
    assert main(["trace", str(path), "--inertia", "350", "--report", str(report), "--json", "-"]) == 0
    printed = capsys.readouterr()
    found = json.loads(printed.out)
    assert "drag_step" in [each["effect"] for each in found["effects"]]
    (part,) = found["parts"]
    assert part["after"] == ["drag_step"]
    assert part["from"] == pytest.approx(HULL, abs=1.0)
    assert part["to"] is None
    assert "drag_step" not in [each["effect"] for each in part["effects"]]
    sentence = f"the rest of the recording shows: {part['headline']}"
    assert sentence in printed.err
    assert f"--from {part['from']:.6g}" in printed.err
    assert "the rest of the recording shows" in report.read_text(encoding="utf-8")
    # what it says to type gives that headline
    assert main(["trace", str(path), "--inertia", "350", "--from", f"{part['from']:.6g}", "--json", "-"]) == 0
    alone = json.loads(capsys.readouterr().out)
    assert alone["verdict"] == part["verdict"]
    assert "parts" not in alone


def test_where_nothing_steps_nothing_is_traced_again(plain: Trace, recording: Recording) -> None:
    assert spans(plain, recording) == []
    bias = Finding("bias_torque", (), {"moment_nm": 3.0}, {"moment_nm": (2.0, 4.0)}, 1e-9, 1.0, (), "", "")
    assert spans(plain, recording, bias) == []


def test_each_step_has_its_part(plain: Trace, recording: Recording) -> None:
    """It begins where the step is over for certain, and ends where the next one may have begun."""
    late, early = stepping("thrust_step", 450.0), stepping("drag_step", 200.0, 195.0, 206.0)
    assert spans(plain, recording, late, early) == [(("drag_step",), 206.0, 450.0), (("thrust_step",), 450.0, inf)]


def test_steps_that_cannot_be_told_apart_are_one(plain: Trace, recording: Recording) -> None:
    one, other = stepping("drag_step", 300.0, 290.0, 310.0), stepping("thrust_step", 305.0, 300.0, 312.0)
    assert spans(plain, recording, one, other) == [(("drag_step", "thrust_step"), 312.0, inf)]
    soon = stepping("thrust_step", 330.0)
    assert spans(plain, recording, one, soon) == [(("drag_step", "thrust_step"), 330.0, inf)]


def test_a_short_part_is_not_traced(plain: Trace, recording: Recording) -> None:
    assert spans(plain, recording, stepping("drag_step", 580.0)) == []


def test_a_part_that_cannot_be_traced_says_why(plain: Trace, recording: Recording) -> None:
    def refuses(_: Sequence[Recording]) -> Trace:
        raise BadInput("too little motion")

    (part,) = after_steps(replace(plain, effects=(stepping("drag_step", 300.0),)), [recording], refuses)
    assert part.sentence.endswith("cannot be traced: too little motion")
    assert part.to_dict()["refused"] == "too little motion"


def test_a_part_ends_before_the_next_step(plain: Trace, recording: Recording) -> None:
    """Also where that one has no part of its own, because a third one follows soon or the recording ends."""
    first, second, third = (stepping("drag_step", at, at - 2.0, at + 2.0) for at in (100.0, 400.0, 410.0))
    assert [part[1:] for part in spans(plain, recording, first, second, third)] == [(102.0, 398.0), (412.0, inf)]
    assert [part[1:] for part in spans(plain, recording, first, stepping("thrust_step", 590.0))] == [(102.0, 590.0)]


def test_the_flag_counts_as_a_cut_does_where_stamps_count_since_1970(plain: Trace, recording: Recording) -> None:
    start = 1_700_000_000.0
    late = replace(recording, time=recording.time + start)
    steps = (stepping("drag_step", start + 200.0), stepping("thrust_step", start + 450.25))
    one, other = after_steps(replace(plain, effects=steps), [late], lambda _: plain)
    assert one.sentence.startswith("from 200 to 450.25 s, after drag_step")
    assert one.sentence.endswith("(--from 200 --to 450.25 traces it alone)")
    assert "--from 450.25 traces" in other.sentence
    assert other.to_dict()["from"] == start + 450.25
