"""The report of a trace: self-contained, complete, and it says what the trace says."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from incsvr.plant.axes import AXES
from incsvr.tracing.findings import Trace, UnexplainedChannel
from incsvr.tracing.result import trace
from incsvr.tracing.run import Run
from incsvr.tracing.sentences import headline, limits
from service.fitting.trace import text
from tests.worlds import trial
from viewer.charts import WITHOUT, free_runs, hint, told_apart
from viewer.report import trace_page
from viewer.report.trace_page import derivatives

MADE = {"recordings": "run.csv", "command": "incsvr trace run.csv --inertia 350"}


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


def traced(rate_name: str) -> Trace:
    """A simulated turn with a constant torque that is not declared, traced as the motion of this velocity."""
    outcome = trial(3, ("bias_torque",), duration=120.0, size=2.0)
    columns = dict(outcome.recording.columns)
    run = Run("run", outcome.recording.time, columns.pop("yaw_rate"), columns.pop("torque"), columns, rate_name)
    return trace([run], inertia=outcome.inertia)


@pytest.fixture(scope="module")
def found() -> Trace:
    return traced("yaw_rate")


@pytest.fixture(scope="module")
def report(found: Trace) -> str:
    """Its page."""
    return trace_page(found, provenance=MADE)


def test_the_report_says_what_it_was_made_of_and_the_derivatives(found: Trace, report: str) -> None:
    for said in ("run.csv", "incsvr trace run.csv --inertia 350", "I − N_r\u0307", "prefers-color-scheme: dark"):
        assert said in report
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


def test_the_report_is_one_file_that_says_what_was_found(found: Trace, report: str) -> None:
    page = Text()
    page.feed(report)
    words = re.sub(r"\s+", " ", " ".join(page.words))
    assert page.loads == []
    assert [finding.effect for finding in found.effects] == ["bias_torque"]
    assert "Adding bias torque lowers the free run's error" in words
    for finding in found.effects:
        assert finding.sentence in words
    for rejected in found.rejected:
        assert rejected.reason in words
    for when in ("before", "after"):
        assert f"{found.error[when]['free_run_rmse']:.3g}" in words
    for label in ("torque, mean absolute error", "torque, root mean square error", "yaw rate in free run"):
        assert label in words
    shown, _ = told_apart(found.pictures.depends, found.pictures.residual_before, found.pictures.residual_after)
    drawn = min(4, len(found.pictures.after.time)) + len(shown) + 2
    assert report.count("<svg") == drawn
    for name in shown:
        assert hint(name) in words
    assert headline(found).replace("_", " ")[1:] in words


@pytest.mark.slow
def test_what_limits_a_verdict_is_on_terminal_and_page(found: Trace) -> None:
    """The verdict and each limit are one sentence on both."""
    assert found.proven

    def changed(**parts: Any) -> dict[str, Any]:
        return {**found.error, **parts}

    worse = {"estimate": 0.01, "low": 0.005, "high": 0.02}
    grown = changed(
        after={**found.error["after"], "free_run_rmse": 0.9 * found.error["trivial"]["zero"]["free_run_rmse"]},
        change={**found.error["change"], "free_run_rmse": worse},
    )
    much = changed(disturbance={**found.error["disturbance"], "share_of_torque": 0.87})
    every = replace(found, error={**grown, **much, "change": grown["change"]}, proven=False, one_clock=False)
    page = Text()
    page.feed(trace_page(every))
    words = " ".join(" ".join(page.words).split()).lower()
    assert len(limits(every)) == 2
    cautions = "".join(f"  caution: {limit}\n" for limit in limits(every))
    assert text(every).startswith(f"declared inertia {every.inertia:g} kg m²: {headline(every)}\n{cautions}")
    for clause in (headline(every), *limits(every)):
        assert clause.replace("_", " ").lower() in words


def test_free_runs_of_other_pieces_are_drawn_beside_those_of_the_same_motion(found: Trace) -> None:
    """Another inertia has another time scale, and so other pieces; stamps of two recordings may overlap."""
    after = found.pictures.after
    joined = replace(
        found.pictures.before,
        **{name: (np.concatenate(getattr(found.pictures.before, name)),) for name in ("time", "measured", "simulated")},
    )
    other = replace(joined, measured=(joined.measured[0] + 1.0,))
    assert f"simulated {WITHOUT}" in free_runs(joined, after, found.model.scale)[0]
    assert WITHOUT not in free_runs(other, after, found.model.scale)[0]


@pytest.mark.slow
def test_a_coefficient_whose_interval_holds_a_negative_drag_is_flagged(found: Trace) -> None:
    turned = replace(
        found,
        pictures=replace(
            found.pictures,
            residual_after=-2.0 * found.model.damping_at(np.nan_to_num(found.pictures.depends["yaw_rate"])),
        ),
    )
    assert "drives instead of damping" in trace_page(turned)


@pytest.mark.slow
def test_the_same_trace_gives_the_same_report(found: Trace, report: str) -> None:
    assert trace_page(found, provenance=MADE) == report


@pytest.mark.slow
def test_no_chance_is_printed_as_zero(found: Trace) -> None:
    findings = tuple(replace(finding, p_value=0.0) for finding in found.effects)
    rejected = (replace(found.rejected[0], p_value=0.0), replace(found.rejected[1], p_value=0.25))
    page = Text()
    page.feed(trace_page(replace(found, effects=findings, rejected=rejected)))
    assert [word for word in page.words if word.strip().startswith("p < 1e−300, corrected for the search")]
    cells = [word.strip() for word in page.words]
    assert "< 1e−300" in cells
    assert "0.25" in cells
    surely = replace(found, unexplained=(UnexplainedChannel("depth", 0.0),))
    assert "depth still predicts the residual (p < 1e-300)" in text(surely)
    assert surely.to_dict()["unexplained"] == [{"channel": "depth", "p_value": 0.0}]
