"""The engine's rows and stages mean the contract's parameters, with their signs, units and intervals."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pytest

from incsvr.model import rows as catalogue
from incsvr.model.candidates import Candidate, candidates
from incsvr.model.factors import one_by_one
from incsvr.model.fitting import Fit, fit
from incsvr.model.identification import plain_fit, pool, structure_of
from incsvr.model.intervals import halved
from incsvr.model.predictor import frequencies
from incsvr.model.rows import Row
from incsvr.numerics import Array
from incsvr.plant.words import YAW_WORDS
from incsvr.tracing.effect_values import Here
from incsvr.tracing.model import TracedModel
from incsvr.tracing.parameters import ends, has_size, parameters_of
from incsvr.tracing.recordings import Recordings, recordings_of
from incsvr.tracing.sentences import LABELS
from incsvr.tracing.traced_model import traced_model
from incsvr.tracing.vocabulary import WORDS, contract_name, streams, word_of
from service.fitting.trace import runs_of
from simulator.mission import Mission
from simulator.vehicles import TURNING
from simulator.world import Outcome, play_together

HEADING = np.linspace(-4.0, 4.0, 41)
TIME = np.linspace(0.0, 100.0, 41)
RATE = np.linspace(-0.5, 0.5, 41)


def moment(rows: Mapping[str, Row], theta: Mapping[str, float], signals: Mapping[str, Array]) -> Array:
    """What rows apply: minus θ times their factors."""
    parts = [(theta[key], row.parts[0]) for key, row in rows.items()]
    taken = [at * one_by_one(p.one, signals) * one_by_one(p.other, signals) for at, p in parts]
    return np.asarray(-np.sum(taken, axis=0))


def at(name: str, rows: Mapping[str, Row]) -> Here:
    of = name.partition("@")[0].partition(":")[2]
    return Here("yaw_rate", of, rows, 24.0, 1000.0, 100.0, 5.0, {"linear@yaw_rate": 0.1}, 0.02, 0.05)


def keyed(rows: tuple[Row, ...]) -> dict[str, Row]:
    return {row.key: row for row in rows}


@pytest.mark.parametrize("name", ["heading_current", "heading_current:2"])
def test_a_pair_of_rows_is_an_amplitude_and_a_phase_of_the_heading(name: str) -> None:
    rows = keyed(catalogue.turned("yaw_rate")[name])
    theta = dict(zip(rows, (-0.7, 1.1), strict=True))
    found = word_of(name).parameters(theta, at(f"{name}@yaw_rate", rows))
    wanted = found["amplitude_nm"] * np.sin(found["harmonic"] * HEADING + found["phase_rad"])
    assert moment(rows, theta, {"heading": HEADING}) == pytest.approx(wanted)
    assert contract_name(name) == "heading_current"
    assert streams(f"{name}@yaw_rate") == ("heading",)


def test_a_wave_is_an_amplitude_a_phase_and_a_period() -> None:
    ((name, pair),) = catalogue.waves("yaw_rate", [0.31]).items()
    rows = keyed(pair)
    theta = dict(zip(rows, (0.4, 0.9), strict=True))
    found = word_of(name).parameters(theta, at(f"{name}@yaw_rate", rows))
    wanted = found["amplitude_nm"] * np.sin(2.0 * math.pi * TIME / found["period_s"] + found["phase_rad"])
    assert moment(rows, theta, {"time": TIME}) == pytest.approx(wanted)
    half = word_of(name).unsure(at(f"{name}@yaw_rate", rows), found, {"amplitude_nm": 0.1})
    assert 0.0 < half["period_s"] < found["period_s"] / 4.0


def test_a_tether_has_a_stiffness_and_a_neutral_heading() -> None:
    rows = keyed(catalogue.turned("yaw_rate")["tether"])
    theta = {"tether@yaw_rate": 0.5, "bias_torque@yaw_rate": 0.2}
    found = word_of("tether").parameters(theta, at("tether@yaw_rate", rows))
    wanted = -found["stiffness_nm_per_rad"] * (HEADING - found["neutral_rad"])
    assert moment(rows, theta, {"heading": HEADING}) == pytest.approx(wanted)


def test_changes_during_a_recording_are_fractions_of_damping_and_thrust() -> None:
    every = catalogue.of_time("yaw_rate", [40.0], driven=True)
    theta = {row.key: 0.3 for pair in every.values() for row in pair} | {"linear@yaw_rate": 3.0}
    found = {name: word_of(name).parameters(theta, at(name, keyed(pair))) for name, pair in every.items()}
    assert found["drag_step:40"] == {"fraction": pytest.approx(0.3 * 0.02 / 0.3), "at_s": 1040.0}
    assert found["drag_drift"] == {"fraction": pytest.approx(0.3 * 100.0 * 0.02 / 0.3)}
    assert found["thrust_step:40"] == {"fraction": -0.3, "at_s": 1040.0}
    assert found["thrust_drift"] == {"fraction": -30.0}
    assert found["bias_drift"] == {"nm_per_s": -0.3, "start_nm": -0.3}
    assert word_of("drag_step:40").unsure(at("drag_step:40", {}), {}, {}) == {"at_s": 5.0}
    assert word_of("delay@yaw_rate").unsure(at("delay@yaw_rate", {}), {}, {}) == {"delay_s": 0.05}


def test_friction_has_a_moment_for_either_direction() -> None:
    rows = {row.key: row for row in catalogue.own("yaw_rate", 0.5, driven=False) if row.name.startswith("coulomb")}
    theta = {"coulomb@yaw_rate": 0.5, "coulomb_asymmetry@yaw_rate": 0.2}
    found = word_of("coulomb_asymmetry").parameters(theta, at("coulomb_asymmetry@yaw_rate", rows))
    applied = moment(rows, theta, {"yaw_rate": RATE})
    assert (applied[-1], applied[0]) == pytest.approx((-found["moment_forward_nm"], found["moment_backward_nm"]))


def test_other_rows_and_stages_have_their_sign_and_unit() -> None:
    theta = {
        "bias_torque@yaw_rate": 2.0, "memory@yaw_rate": -3.0, "time:memory@yaw_rate": math.log(5.0),
        "coriolis:sway*surge@yaw_rate": 12.0, "modulation:depth:thrust@yaw_rate": 0.1, "lag:yaw_rate": math.log(0.7),
        "mass:yaw_rate": math.log(30.0), "coupling:roll@yaw_rate": 1.5,
    }  # fmt: skip
    (thrust,) = (row for row in catalogue.of_channel("yaw_rate", "depth", 6.0, True) if row.name.endswith(":thrust"))

    def of(name: str) -> Mapping[str, float]:
        return word_of(name).parameters(theta, at(name, {thrust.key: thrust}))

    assert of("bias_torque@yaw_rate") == {"moment_nm": -2.0}
    assert of("memory@yaw_rate") == {"gain_nm_s": 3.0, "time_constant_s": pytest.approx(5.0)}
    assert of("coriolis:sway*surge@yaw_rate") == {"coefficient": 12.0, "ratio": 0.5}
    assert of("modulation:depth:thrust@yaw_rate") == {"coefficient": -0.1, "reference": 6.0}
    assert of("lag@yaw_rate") == {"time_constant_s": pytest.approx(0.7)}
    assert of("inertia@yaw_rate") == {"inertia_kg_m2": pytest.approx(30.0)}
    assert of("coupling:roll@yaw_rate") == {"coefficient": -1.5}
    assert contract_name("coriolis:sway*surge@yaw_rate") == "coriolis:surge*sway"
    assert contract_name("modulation:depth:thrust@yaw_rate") == "modulation:depth"
    assert contract_name("square:sway@surge") == "coriolis:sway*sway"
    assert streams("coriolis:surge*yaw_rate@yaw_rate") == ("surge",)
    assert streams("square:sway@surge") == ("sway",)


@pytest.mark.parametrize(
    ("spans", "known"),
    [
        ({"moment_nm": (-0.1, 0.5)}, False), ({"moment_nm": (0.1, 0.5), "at_s": (-1.0, 1.0)}, True),
        ({"delay_s": (0.05, 0.3)}, False), ({"delay_s": (-0.4, -0.2)}, True), ({"exponent": (0.9, 1.1)}, False),
        ({"inertia_kg_m2": (25.0, 27.0)}, True), ({"time_constant_s": (0.01, 8.0)}, False),
        ({"time_constant_s": (0.3, 0.5)}, True), ({"half_width_nm": (0.5, 0.7)}, True),
        ({"half_width_nm": (0.2, 0.45)}, False), ({"half_width_nm": (0.3, 4.0)}, False),
    ],
)  # fmt: skip
def test_a_name_needs_a_size(spans: dict[str, tuple[float, float]], known: bool) -> None:
    assert has_size(spans, inertia=24.0, period=0.1, band=0.4) == known


def test_ends_of_what_is_positive_by_nature_are_positive() -> None:
    assert ends("limit_nm", 2.0, 4.0) == pytest.approx((2.0 * math.exp(-2.0), 2.0 * math.exp(2.0)))
    assert ends("moment_nm", 2.0, 4.0) == (-2.0, 6.0)


def test_sentences_are_templates_of_the_words_of_an_axis() -> None:
    for kind, word in WORDS.items():
        assert len(YAW_WORDS.fill(word.sentence)) > 20, kind
        assert YAW_WORDS.fill(word.shown_by) == YAW_WORDS.fill(YAW_WORDS.fill(word.shown_by)), kind


EFFECTS = {
    "bias_torque": 0, "inertia": 1, "torque_lag": 7, "dead_zone": 3, "torque_delay": 4, "torque_asymmetry": 5,
    "torque_saturation": 8, "inflow": 6, "heading_current": 8, "tether": 13, "wave": 10, "drag_drift": 11,
    "drag_step": 12, "memory": 9, "coulomb": 14, "bias_drift": 15, "coupling:ballast_flow": 16,
    "modulation:voltage": 17,
}  # fmt: skip
"""Hidden effects, and the seed of each over 990000: one that draws the shape of the engine's row or stage."""


@dataclass(frozen=True, slots=True)
class Played:
    outcome: Outcome
    recordings: Recordings
    plain: Fit
    candidates: tuple[Candidate, ...]


def fitted(outcome: Outcome) -> Played:
    (run,) = runs_of([outcome.recording])
    hidden = outcome.mission.hidden[0]
    read = [name for name in run.channels if name == "heading" or hidden.endswith(f":{name}")]
    recordings = recordings_of([run], read)
    given = {"yaw_rate": outcome.inertia}
    plain = plain_fit(structure_of(recordings.streams, ["yaw_rate"], recordings.channels, given), recordings.streams)
    effects = pool(plain.structure, recordings.streams)
    if hidden == "wave":
        effects |= catalogue.waves("yaw_rate", frequencies(plain, 0))
    every = candidates(plain.structure, plain.theta, effects, plain.problem.windows)
    return Played(outcome, recordings, plain, tuple(every))


@pytest.fixture(scope="module")
def played() -> dict[str, Outcome]:
    missions = [
        Mission(
            TURNING["auv"], "telegraph", 990_000 + seed, hidden=(name,), duration=240.0,
            channels=tuple(name.split(":")[1:]),
        )
        for name, seed in EFFECTS.items()
    ]  # fmt: skip
    return dict(zip(EFFECTS, play_together(missions), strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("name", EFFECTS)
def test_a_hidden_effect_has_its_true_parameters(name: str, played: dict[str, Outcome]) -> None:
    """Within twice the half width of the interval: of eighteen intervals of 95 % one excludes the truth."""
    one = fitted(played[name])
    assert {word_of(each.name) for each in one.candidates} <= set(WORDS.values())
    shown = [each for each in one.candidates if contract_name(each.name) == name]
    fits = {
        k: fit(each.structure, {**one.plain.theta, **each.start}, one.plain.problem, one.plain.starts)
        for k, each in enumerate(shown)
    }
    best = min(fits, key=lambda k: fits[k].value)
    ((found, spans),) = parameters_of(
        fits[best], [shown[best].name], one.outcome.inertia, one.recordings.begin, [halved(fits[best])]
    )
    model = traced_model(
        fits[best],
        {shown[best].name: tuple(shown[best].start)},
        one.outcome.inertia,
        one.recordings.begin,
        1.0,
        1.0,
        4.0,
    )
    assert [effect.name for effect in model.effects] == [name]
    assert model.theta == {key: fits[best].theta[key] for key in shown[best].start}
    again = TracedModel.from_dict(json.loads(json.dumps(model.to_dict())))
    assert again.effects == model.effects
    assert again.added_to(one.plain.structure).rows == model.added_to(one.plain.structure).rows
    truth = one.outcome.truth[name]
    for key in set(found) & set(truth) - {"harmonic"}:
        low, high = spans[key]
        away = float(truth[key]) - found[key]
        away = math.remainder(away, 2.0 * math.pi) if key == "phase_rad" else away
        assert abs(away) < high - low, (key, truth, found, spans)
    assert set(found) <= set(LABELS)
