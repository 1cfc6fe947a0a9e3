"""The report of a trace: self-contained, complete, and it says what the trace says."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES
from incsvr.tracing import Trace, trace
from incsvr.tracing.findings import Unexplained
from incsvr.tracing.run import Run
from simulator.trace import text
from simulator.trial import Trial, play
from viewer.report import write
from viewer.report.charts import told_apart
from viewer.report.derivatives import derivatives


class Text(HTMLParser):
    """Collects the words of a page, and the names of what it would load from elsewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.words: list[str] = []
        self.loads: list[str] = []

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name in ("src", "href", "xlink:href") and value and not value.startswith(("#", "data:")):
                self.loads.append(f"{tag} {value}")


@pytest.fixture(scope="module")
def found() -> Trace:
    outcome = play(Trial(seed=3, effects=("bias_torque",), size=2.0, duration=360.0))
    columns = dict(outcome.recording.columns)
    run = Run("run", outcome.recording.time, columns.pop("yaw_rate"), columns.pop("torque"), columns)
    return trace([run], inertia=outcome.inertia)


def test_the_report_says_what_it_was_made_of_and_the_derivatives(found: Trace, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    write(found, path, made={"recordings": "run.csv", "command": "incsvr trace run.csv --inertia 350"})
    text = path.read_text(encoding="utf-8")
    for said in ("run.csv", "incsvr trace run.csv --inertia 350", "I − N_r\u0307", "prefers-color-scheme: dark"):
        assert said in text
    (linear, quadratic, inertia), (slowest, fastest) = derivatives(found)
    rate = np.linspace(slowest, fastest, 41)
    curve = linear.value * rate + quadratic.value * rate * np.abs(rate)
    away = np.sqrt(np.mean((curve - found.model.damping_at(rate)) ** 2))
    assert away < 0.1 * np.sqrt(np.mean(curve**2))
    for each in (linear, quadratic):
        assert each.interval is not None
        assert each.interval[0] < each.value < each.interval[1]
    assert (inertia.value, inertia.interval) == (found.inertia, None)
    assert [each.symbol for each in derivatives(found, AXES["sway"])[0]] == ["Y_v", "Y_v|v|", "m − Y_v\u0307"]


def test_a_channel_is_shown_where_there_is_something_to_see() -> None:
    random = np.random.default_rng(1)
    channels = {"yaw_rate": random.normal(size=900), "sway": random.normal(size=900), "depth": random.normal(size=900)}
    after = random.normal(size=900)
    shown, flat = told_apart(channels, after + 2.0 * channels["sway"], after)
    assert ([*shown], flat) == (["yaw_rate", "sway"], ("depth",))


def test_the_report_is_one_file_that_says_what_was_found(found: Trace, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    write(found, path)
    page = Text()
    page.feed(path.read_text(encoding="utf-8"))
    words = re.sub(r"\s+", " ", " ".join(page.words))
    assert page.loads == []
    assert [finding.effect for finding in found.effects] == ["bias_torque"]
    assert "The model lacks bias torque" in words
    for finding in found.effects:
        assert finding.sentence in words
    for rejected in found.rejected:
        assert rejected.reason in words
    for when in ("before", "after"):
        assert f"{found.error[when]['free_run_rmse']:.3g}" in words
    for label in ("torque, mean absolute error", "torque, root mean square error", "yaw rate in free run"):
        assert label in words
    assert path.read_text(encoding="utf-8").count("<svg") == 4


def test_the_same_trace_gives_the_same_report(found: Trace, tmp_path: Path) -> None:
    write(found, tmp_path / "one.html")
    write(found, tmp_path / "two.html")
    assert (tmp_path / "one.html").read_bytes() == (tmp_path / "two.html").read_bytes()


def test_a_place_that_cannot_be_written_is_said(found: Trace, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="name another file"):
        write(found, tmp_path / "nowhere" / "report.html")


def test_no_chance_is_printed_as_zero(found: Trace, tmp_path: Path) -> None:
    findings = tuple(replace(finding, p_value=0.0) for finding in found.effects)
    rejected = (replace(found.rejected[0], p_value=0.0), replace(found.rejected[1], p_value=0.25))
    write(replace(found, effects=findings, rejected=rejected), tmp_path / "report.html")
    page = Text()
    page.feed((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert [word for word in page.words if word.strip().startswith("p < 1e−300, corrected for the search")]
    cells = [word.strip() for word in page.words]
    assert "< 1e−300" in cells
    assert "0.25" in cells
    surely = replace(found, unexplained=(Unexplained("depth", 0.0),))
    assert "depth still predicts the residual (p < 1e-300)" in text(surely)
    assert surely.to_dict()["unexplained"] == [{"channel": "depth", "p_value": 0.0}]


def test_of_another_axis_it_says_its_words_and_units(found: Trace, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    write(found.in_terms_of(AXES["sway"]), path, AXES["sway"])
    page = Text()
    page.feed(path.read_text(encoding="utf-8"))
    words = re.sub(r"\s+", " ", " ".join(page.words))
    assert re.findall(r".{30}(?:(?<!\*)[Yy]aw|rad/s|N m|kg m²|d\(r\)|Iṙ).{20}", words) == []
    for own in (
        "Sway motion model, declared mass",
        "sway velocity v [m/s]",
        "force τ [N]",
        "damping d(v) [N]",
        "mv̇ − d(v)",
    ):
        assert own in words
