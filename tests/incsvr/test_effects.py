"""One harness of checks over every effect of the catalogue."""

from __future__ import annotations

import ast
import re
from dataclasses import fields, replace

import numpy as np
import pytest

from incsvr.effects import Effect, Signals, Term, candidates
from incsvr.model_trace.model import TracedModel
from incsvr.model_trace.sentences import LABELS
from incsvr.numerics import Array
from incsvr.plant.words import AxisWords
from incsvr.tracing.effect_sentences import sentence
from incsvr.tracing.of_model import drag_of, parts_of, simulated
from tests.conftest import ROOT

EVERY = list(candidates(["winch"]))
VOCABULARY = {
    "bias_torque", "inertia", "torque_lag", "torque_delay", "dead_zone", "torque_asymmetry", "torque_saturation",
    "inflow", "heading_current", "tether", "wave", "drag_drift", "drag_step", "memory", "coulomb", "bias_drift",
    "coupling:winch", "modulation:winch", "thrust_step", "thrust_drift", "thrust_curve", "gyro_bias",
    "coulomb_asymmetry",
}  # fmt: skip
SIZES = {
    "bias_torque": (4.0,), "inertia": (50.0,), "torque_lag": (0.7,), "torque_delay": (0.7,), "dead_zone": (1.0,),
    "torque_asymmetry": (0.2,), "inflow": (6.0,), "heading_current": (4.0, 3.0), "tether": (2.0, 0.5),
    "wave": (4.0, 2.0), "drag_drift": (0.3,), "drag_step": (0.3,), "memory": (-60.0,), "coulomb": (5.0,),
    "bias_drift": (0.02, -1.0), "coupling:winch": (3.0, 0.5), "thrust_step": (-0.3,), "thrust_drift": (-0.3,),
    "thrust_curve": (1.0,), "gyro_bias": (0.02,), "coulomb_asymmetry": (5.0, 3.0),
}  # fmt: skip
"""θ of a realistic size for the plant below; the keys that are missing depend on the variant."""


def coefficients(effect: Effect) -> tuple[float, ...]:
    if effect.name == "torque_saturation":
        return (0.002,) if effect.variant == "coefficient" else (1.0,)
    if effect.key == "tether/slack":
        return (2.0,)
    if effect.name == "modulation:winch":
        return (0.1, -0.05) if "level" in effect.variant else (0.1,)
    return SIZES[effect.name]


@pytest.fixture(scope="module")
def signals() -> Signals:
    """Two runs of a multisine command and the motion it gave a plain vehicle, on a fine grid of 0.1 s."""
    step, n = 0.1, 3000
    time = np.asarray(step * np.arange(n), dtype=np.float64)
    torque = 60.0 * np.sin(2 * np.pi * time / 37.0) + 30.0 * np.sin(2 * np.pi * time / 11.0 + 1.0)
    start = np.array([0, n // 2, n])
    winch = 2.0 + np.sin(2 * np.pi * time / 53.0)
    plain = Signals(
        step, start, time, np.zeros(n), torque, {"winch": winch}, np.zeros(n), scale=6.0, block=0.8, origin=(0.0, 300.0)
    )
    table = np.linspace(-0.3, 0.3, 61)
    model = TracedModel(350.0, table, 100.0 * table + 500.0 * table * np.abs(table), (), 1.0, 0.8, 6.0, (0.0, 300.0))
    _, rate = simulated(model, plain)
    return replace(moved(plain, rate), damping=model.damping_at(rate), drag=drag_of(model), applied=torque,
                   inertia=350.0, residual=np.sin(2 * np.pi * time / 6.1))  # fmt: skip


def moved(signals: Signals, rate: Array) -> Signals:
    """The signals with this yaw rate, its integral as heading in each run, and its slope."""
    heading, acceleration = np.empty(rate.size), np.empty(rate.size)
    for run in signals.runs():
        heading[run] = signals.step * (np.cumsum(rate[run]) - rate[run])
        acceleration[run] = np.append(np.diff(rate[run]), 0.0) / signals.step
    return replace(signals, rate=rate, heading=heading, acceleration=acceleration)


def model_with(effect: Effect, signals: Signals) -> TracedModel:
    starts = effect.starts(signals)
    inner = () if effect.from_start else starts[len(starts) // 2]
    table = np.linspace(-0.3, 0.3, 61)
    term = Term(effect.name, effect.variant, coefficients(effect), inner)
    damping = 100.0 * table + 500.0 * table * np.abs(table)
    return TracedModel(350.0, table, damping, (term,), 1.0, 0.8, 6.0, (0.0, 300.0))


def test_the_catalogue_is_the_contracts_vocabulary() -> None:
    assert {effect.name for effect in EVERY} == VOCABULARY
    assert len({effect.key for effect in EVERY}) == len(EVERY)


@pytest.mark.parametrize("effect", EVERY, ids=lambda effect: effect.key)
class TestEveryEffect:
    def test_parameters_have_labels_and_survive_json(self, effect: Effect, signals: Signals) -> None:
        model = model_with(effect, signals)
        parameters = effect.parameters(model.terms[0], 350.0)
        assert parameters
        assert set(parameters) <= set(LABELS)
        assert effect.name in sentence(effect, parameters, dict.fromkeys(parameters, (0.0, 1.0)), 0.5)
        again = TracedModel.from_dict(model.to_dict())
        assert again.terms == model.terms
        np.testing.assert_array_equal(again.damping, model.damping)

    def test_it_bounds_the_free_run_and_its_ledger_adds_up_to_the_command(
        self, effect: Effect, signals: Signals
    ) -> None:
        """The equation form and the simulation say the same physics: simulate, then split the torque into its parts."""
        model = model_with(effect, signals)
        _, rate = simulated(model, signals)
        assert np.max(np.abs(rate)) < 1.5
        assert np.sqrt(np.mean((rate - signals.rate) ** 2)) > 1e-4
        seen = moved(signals, rate)
        settled = np.concatenate([np.arange(run.start + 100, run.stop - 2) for run in signals.runs()])
        parts = parts_of(model, seen)
        left = (np.sum(list(parts.values()), axis=0) - seen.torque)[settled]
        assert list(parts) == ["declared inertia", "damping", effect.name]
        assert np.sqrt(np.mean(left**2)) < 1.5  # of a command of 95 N m


def test_a_template_names_only_words_that_there_are() -> None:
    """What a check or an effect writes is filled while a vehicle learns: a word that is not there would end that."""
    there, named = {each.name for each in fields(AxisWords)}, set[str]()
    for path in (*(ROOT / "incsvr/checks").glob("*.py"), *(ROOT / "incsvr/effects").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                named |= set(re.findall(r"(?<!_)\{(\w+)\}", node.value))
    assert {"rate", "effort", "moment", "effort_unit"} <= named <= there
