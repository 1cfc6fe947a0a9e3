"""No sentence on a trace is denied by a figure: results are drawn at random, and every sentence on them is read."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from incsvr.compensation.proof import Proof, errors
from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from incsvr.plant.words import words_of
from incsvr.tracing.effects_found import sentence
from incsvr.tracing.findings import Finding, Pictures, RejectedEffect, Trace, UnexplainedChannel
from incsvr.tracing.held_out import Errors, beats_zero
from incsvr.tracing.model import TracedModel
from incsvr.tracing.result import NO_SIZE
from incsvr.tracing.sentences import headline, limits
from incsvr.tracing.spells import sentence as of_spells
from incsvr.tracing.spells import spans
from incsvr.tracing.vocabulary import contract_name
from service.fitting.trace import text

MAX_HEADLINE_WORDS = 25
N = r"([-+−]?\d+\.?\d*(?:e[-+−]?\d+)?)"
"""A number, as people and pages write it."""
EFFECTS = {
    "bias_torque": ("moment_nm",), "delay": ("delay_s",), "wave:9": ("amplitude_nm", "phase_rad", "period_s"),
    "thrust_step:30": ("fraction", "at_s"), "coriolis:surge*sway": ("coefficient", "ratio"),
    "tether": ("stiffness_nm_per_rad", "neutral_rad"), "memory": ("gain_nm_s", "time_constant_s"),
}  # fmt: skip
"""The engine's names of some effects, each with its parameters."""
SIZE, PART = st.floats(1e-4, 1e3), st.floats(0.0, 1.0)


NOTHING: Array = np.zeros(2)
MODEL = TracedModel(350.0, np.array([-0.2, 0.2]), NOTHING, (), 1.0, 0.1, 0.6, (0.0, 60.0))
ERRORS = Errors((), (), (), ())
KNOWN = {
    "floor": {"torque_rmse": 1.0},
    "horizons": {"1": dict.fromkeys(("before", "after", "hold", "zero"), 0.1)},
    "validated_on": "blocks",
}
BARE = Trace(
    350.0, "none", (), (), (), KNOWN, {}, (), MODEL, MODEL,
    Pictures(ERRORS, ERRORS, NOTHING, {}, NOTHING, NOTHING, {}),
)  # fmt: skip


@st.composite
def findings(draw: st.DrawFn, axis: str) -> tuple[Finding, ...]:
    names = draw(st.lists(st.sampled_from(sorted(EFFECTS)), unique=True, max_size=6))
    made = []
    for name in names:
        parameters = {key: draw(st.floats(-1e3, 1e3)) for key in EFFECTS[name]}
        interval = {key: (value - draw(SIZE), value + draw(SIZE)) for key, value in parameters.items()}
        said = sentence(name, parameters, interval, draw(PART), words_of(AXES[axis]))
        made.append(Finding(contract_name(name), (), parameters, interval, draw(PART), draw(PART), (), "", said))
    return tuple(made)


@st.composite
def changes(draw: st.DrawFn, added: bool) -> tuple[float, float, dict[str, float]]:
    """An error before and after, and its change with the interval; none where nothing was added."""
    before = draw(SIZE)
    after = draw(SIZE) if added else before
    low, high = (draw(SIZE) if added else 0.0 for _ in range(2))
    return before, after, {"estimate": after - before, "low": after - before - low, "high": after - before + high}


@st.composite
def traces(draw: st.DrawFn, found: Trace) -> Trace:
    """A consistent result, as `incsvr.tracing.result` makes it."""
    axis, loop = draw(st.sampled_from(sorted(AXES))), draw(st.sampled_from(("open", "closed")))
    effects = draw(findings(axis))
    torque, free = draw(changes(bool(effects))), draw(changes(bool(effects)))
    left = draw(st.one_of(st.just({}), st.builds(lambda part: {"share_of_torque": part}, st.floats(0.0, 2.0))))
    error: dict[str, Any] = found.error | {
        when: {"torque_mae": torque[k], "torque_rmse": torque[k], "free_run_rmse": free[k]}
        for k, when in enumerate(("before", "after"))
    }
    error |= {"change": {"torque_rmse": torque[2], "free_run_rmse": free[2]}}
    error |= {"trivial": {name: {"free_run_rmse": draw(SIZE)} for name in ("zero", "hold")}}
    error |= {"disturbance": {"torque_rmse": draw(SIZE), "correlation_time_s": draw(SIZE), **left}}
    channels = draw(st.lists(st.sampled_from(("depth", "voltage", "time", "heading")), unique=True))
    verdict = "effects" if effects else "unexplained" if channels else draw(st.sampled_from(("none", "unexplained")))
    stamps = np.concatenate([draw(st.floats(0.0, 60.0)) + 0.1 * np.arange(50) for _ in range(2)])
    spells = spans(stamps, np.array(draw(st.lists(st.booleans(), min_size=100, max_size=100))), 0.1)
    return replace(
        found, axis=AXES[axis], loop=loop, effects=effects, error=error, verdict=verdict,
        proven=bool(effects) and is_proven(error, loop == "closed"), spans=spells,
        sought=bool(effects or channels) or draw(st.booleans()), one_clock=draw(st.booleans()),
        unexplained=tuple(UnexplainedChannel(name, draw(PART)) for name in channels),
        doubts=draw(st.sampled_from(((), ("the inertia is doubted",)))),
        notes=(of_spells(spells),) if spells else (),
        rejected=(RejectedEffect("tether", 0.2, NO_SIZE, refused=True),),
    )  # fmt: skip


def is_proven(error: dict[str, Any], closed: bool) -> bool:
    """Whether errors say that a model is better than the declared one, and than a rate of zero."""
    return bool(error["change"]["torque_rmse" if closed else "free_run_rmse"]["high"] < 0.0) and beats_zero(error)


def number(said: str) -> float:
    return float(said.replace("−", "-"))


def denied(said: str, trace: Trace) -> list[str]:
    """The sentences that a figure denies, in what is said of a trace."""
    found = [match[0] for match in re.finditer(r"\b(?:lowers|raises|grows|falls)\b[^.;\n]* by [-−][^.;\n]*", said)]
    for verb, sign in (("lowers", -1.0), ("falls", -1.0), ("raises", 1.0), ("grows", 1.0)):
        for match in re.finditer(rf"\b{verb}\b[^.;\n]* from {N} to {N}", said):
            found += [match[0]] if sign * (number(match[2]) - number(match[1])) < 0.0 else []
    found += [match[0] for match in re.finditer(rf"{N}–{N} s\b", said) if number(match[1]) > number(match[2])]
    for match in re.finditer(rf"{N} \({N} to {N}\)", said):
        found += [] if number(match[2]) <= number(match[1]) <= number(match[3]) else [match[0]]
    change = trace.error["change"][trace.decisive_error]
    proves = {
        "lowers the": trace.proven,
        "significantly lower": change["high"] < 0.0 and (trace.proven or "but not proven" in said),
        "significantly higher": change["low"] > 0.0,
        "does not differ significantly": change["low"] <= 0.0 <= change["high"],
        "was added": bool(trace.effects) or "Nothing was added" in said,
        "of the improvement": trace.proven,
    }
    return found + [claim for claim, holds in proves.items() if claim in said and not holds]


@pytest.mark.parametrize(
    "said",
    [
        "it lowers the error by -188.9 %",
        "the residual is unusually large at 29.9–4.9 s",
        "the torque's error falls from 51.6 to 56.2 N m",
        "limit 98.8 (99.1 to 111) N m",
        "It accounts for 100 % of the improvement.",
        "open loop: the error of the free run on unseen data is significantly lower",
    ],
)
def test_the_reader_notices(said: str) -> None:
    change = {"free_run_rmse": {"estimate": -1.0, "low": -2.0, "high": 1.0}}
    assert denied(said, replace(BARE, error={"change": change})) != []


@settings(max_examples=80, deadline=None)
@given(data=st.data())
def test_no_sentence_of_a_trace_is_denied_by_its_number(data: st.DataObject) -> None:
    trace = data.draw(traces(BARE))
    first = headline(trace)
    assert len(first.split()) <= MAX_HEADLINE_WORDS, first
    assert not set(";\n") & set(first)
    if trace.beats_zero and trace.verdict == "effects":
        assert ("lowers" in first) == trace.proven
    for said in (first, "\n".join(limits(trace)), text(trace)):
        assert denied(said, trace) == []


@settings(max_examples=80, deadline=None)
@given(change=changes(True), torque=changes(True), closed=st.booleans(), turned=st.booleans(), last=st.booleans())
def test_a_proof_says_by_what_it_is_one(
    change: tuple[float, float, dict[str, float]], torque: tuple[float, float, dict[str, float]], closed: bool,
    turned: bool, last: bool,
) -> None:  # fmt: skip
    runs, efforts, free = change[:2], torque[:2], change[2]
    before, after = ({"torque_rmse": tau, "free_run_rmse": run} for tau, run in zip(efforts, runs, strict=True))
    both = {"torque_rmse": torque[2], "free_run_rmse": free}
    error = {"before": before, "after": after, "change": both, "trivial": {"zero": {"free_run_rmse": 1e9}}}
    compared = Proof(error, closed, is_proven(error, closed), turned)
    said, verdict = compared.sentence(), compared.of_suspected(last)
    assert (" is lower: " in said and turned) == (verdict == "promoted")
    assert (" is higher: " in said and turned) == (compared.of_known() == "withdrawn")
    assert (verdict == "waits") == (not last and not (turned and (compared.better or compared.worse)))
    for told in (said, errors(compared.error)):
        assert ("do not differ provably" in told) == (free["low"] <= 0.0 <= free["high"])
        assert ("err more" in told) == (free["low"] > 0.0)
        for run in re.finditer(rf"free run {N} → {N}", told):
            assert number(run[2]) <= number(run[1])
