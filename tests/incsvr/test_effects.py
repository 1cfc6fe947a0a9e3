"""One harness of checks over every effect of the catalogue."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.effects import Effect, Signals, Term, candidates, catalogue
from incsvr.effects.torque_saturation import Saturation
from incsvr.tracing.model import TracedModel
from incsvr.tracing.sentences import LABELS, sentence

EVERY = list(candidates(["winch"]))
VOCABULARY = {
    "bias_torque", "inertia", "torque_lag", "torque_delay", "dead_zone", "torque_asymmetry", "torque_saturation",
    "inflow", "heading_current", "tether", "wave", "drag_drift", "drag_step", "memory", "coulomb", "bias_drift",
    "coupling:winch", "modulation:winch", "thrust_step", "thrust_drift", "thrust_curve", "gyro_bias",
    "coulomb_asymmetry",
}  # fmt: skip
SIZES = {
    "bias_torque": (4.0,), "inertia": (50.0,), "torque_lag": (0.7,), "torque_delay": (0.7,), "dead_zone": (1.0,),
    "torque_asymmetry": (0.2,), "inflow": (6.0,), "heading_current": (4.0, 3.0), "tether": (2.0,),
    "wave": (4.0, 2.0), "drag_drift": (0.3,), "drag_step": (0.3,), "memory": (-60.0,), "coulomb": (5.0,),
    "bias_drift": (0.02, -1.0), "coupling:winch": (3.0, 0.5), "thrust_step": (-0.3,), "thrust_drift": (-0.3,),
    "thrust_curve": (1.0,), "gyro_bias": (0.02,), "coulomb_asymmetry": (5.0, 3.0),
}  # fmt: skip
"""θ of a realistic size for the plant below; the keys that are missing depend on the variant."""


def coefficients(effect: Effect) -> tuple[float, ...]:
    if effect.name == "torque_saturation":
        return (0.002,) if effect.variant == "coefficient" else (1.0,)
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
    index, simulated = model.simulate(plain, step)
    rate = np.interp(np.arange(n), index, simulated)
    moving = replace(plain, rate=rate)
    return replace(
        moving,
        heading=moving.integral(rate),
        damping=model.damping_at(rate),
        drag=model.drag(),
        acceleration=moving.slope(rate),
        applied=torque,
        command=torque,
        expected=torque,
        predicted_torque=torque,
        residual=np.sin(2 * np.pi * time / 6.1),
        inertia=350.0,
    )


def starts_of(effect: Effect, signals: Signals) -> list[tuple[float, ...]]:
    """Inner parameters to begin with, whichever side of the thrust the effect is seen from."""
    return effect.starts(signals) or effect.starts(replace(signals, torque_noise_fraction=1.0))


def model_with(effect: Effect, signals: Signals) -> TracedModel:
    starts = starts_of(effect, signals)
    inner = starts[len(starts) // 2]
    table = np.linspace(-0.3, 0.3, 61)
    term = Term(effect.name, effect.variant, coefficients(effect), inner)
    damping = 100.0 * table + 500.0 * table * np.abs(table)
    return TracedModel(350.0, table, damping, (term,), 1.0, 0.8, 6.0, (0.0, 300.0))


def test_the_catalogue_is_the_contracts_vocabulary() -> None:
    assert {effect.name for effect in EVERY} == VOCABULARY
    assert len({effect.key for effect in EVERY}) == len(EVERY)


@pytest.mark.parametrize("effect", EVERY, ids=lambda effect: effect.key)
class TestEveryEffect:
    def test_says_its_physics_and_source(self, effect: Effect) -> None:
        assert len(effect.sentence) > 20
        assert any(character.isdigit() for character in effect.source)
        assert effect.__doc__ or type(effect).__mro__[1].__doc__

    def test_columns_are_finite_and_of_the_promised_shape(self, effect: Effect, signals: Signals) -> None:
        for fraction in (0.0, 1.0):
            seen = replace(signals, torque_noise_fraction=fraction)
            for inner in effect.starts(seen):
                columns = effect.columns(seen, inner, ())
                assert columns.shape == (len(signals), len(coefficients(effect)))
                assert np.all(np.isfinite(columns))
                assert 1 <= effect.core <= columns.shape[1]

    def test_sees_no_run_from_within_another(self, effect: Effect, signals: Signals) -> None:
        """What one run does changes nothing in the other's columns, but for levels that all runs share."""
        inner = starts_of(effect, signals)[0]
        whole = effect.columns(signals, inner, ())[signals.start[1] :]
        alone = effect.columns(signals.pieces(signals.runs()[1:]), inner, ())
        np.testing.assert_allclose(whole, alone, rtol=1e-9, atol=1e-9)

    def test_parameters_have_labels_and_survive_json(self, effect: Effect, signals: Signals) -> None:
        model = model_with(effect, signals)
        parameters = effect.parameters(model.terms[0], 350.0)
        assert parameters
        assert set(parameters) <= set(LABELS)
        assert effect.name in sentence(effect, parameters, dict.fromkeys(parameters, (0.0, 1.0)), 0.5)
        again = TracedModel.from_dict(model.to_dict())
        assert again.terms == model.terms
        np.testing.assert_array_equal(again.damping, model.damping)

    def test_a_realistic_size_is_plausible(self, effect: Effect, signals: Signals) -> None:
        assert effect.implausible(model_with(effect, signals).terms[0], signals) == ""

    def test_an_absurd_size_is_not(self, effect: Effect, signals: Signals) -> None:
        term = model_with(effect, signals).terms[0]
        absurd = replace(term, coefficients=tuple(-1e6 * abs(c) - 1e6 for c in term.coefficients))
        assert effect.implausible(absurd, signals) != ""

    def test_changes_the_free_run_and_stays_bounded(self, effect: Effect, signals: Signals) -> None:
        with_effect = model_with(effect, signals)
        _, rate = with_effect.simulate(signals)
        _, plain = replace(with_effect, terms=()).simulate(signals)
        assert np.all(np.isfinite(rate))
        assert np.max(np.abs(rate)) < 1.5
        assert np.sqrt(np.mean((rate - plain) ** 2)) > 1e-4

    def test_the_ledger_of_a_free_run_adds_up_to_the_command(self, effect: Effect, signals: Signals) -> None:
        """The equation form and the simulation say the same physics: simulate, then split the torque into its parts."""
        model = model_with(effect, signals)
        index, simulated = model.simulate(signals, signals.step)
        rate = np.interp(np.arange(len(signals)), index, simulated)
        moved = replace(signals, rate=rate, acceleration=signals.slope(rate))
        starts = [signals.heading[run.start] for run in signals.runs()]
        runs = signals.runs()
        turned = moved.integral(rate) + np.concatenate(
            [np.full(run.stop - run.start, s) for run, s in zip(runs, starts, strict=True)]
        )
        moved = replace(moved, heading=turned)
        settled = np.concatenate([np.arange(run.start + 100, run.stop - 2) for run in runs])
        left = (model.predict(moved) - moved.torque)[settled]
        assert list(model.parts(moved)) == ["declared inertia", "damping", effect.name]
        assert np.sqrt(np.mean(left**2)) < 1.0  # of a command of 95 N m


LAGS = ("torque_lag/moment", "torque_lag/rotor speed", "torque_lag/rotor speed, commanded")


@pytest.mark.parametrize("key", [*LAGS, "torque_delay", "torque_saturation/coefficient"])
def test_a_thrust_effect_says_the_same_from_either_side(key: str, signals: Signals) -> None:
    """What it takes of the torque, once built on the command and once on the moment that acted."""
    effect = catalogue()[key]
    term = Term(effect.name, effect.variant, coefficients(effect))
    acted = effect.thrust(signals.command, signals, term)
    lost = signals.command - acted
    settled = np.concatenate([np.arange(run.start + 50, run.stop - 50) for run in signals.runs()])
    for fraction in (0.0, 1.0):
        seen = replace(signals, torque_noise_fraction=fraction, applied=acted)
        assert seen.from_rate == (fraction == 1.0)
        columns = effect.columns(seen, (), term.coefficients)
        bend = effect.offset(seen, term.coefficients, columns)
        said = columns @ np.array(term.coefficients)
        said = said if bend is None else said + bend
        off = (said - lost)[settled]
        assert np.sqrt(np.mean(off**2)) < 0.01 * np.sqrt(np.mean(lost[settled] ** 2))


def test_a_lag_of_the_rotor_speed_is_no_lag_of_the_moment(signals: Signals) -> None:
    """Where the thrust is small its rotor turns slowly and the moment n |n| follows faster than linearly."""
    moment, rotor = (
        catalogue()[f"torque_lag/{variant}"].thrust(signals.command, signals, Term("torque_lag", variant, (2.0,)))
        for variant in ("moment", "rotor speed")
    )
    assert np.sqrt(np.mean((moment - rotor) ** 2)) > 0.05 * np.sqrt(np.mean((moment - signals.command) ** 2))


def test_only_a_lag_on_the_command_filters_the_torques_noise(signals: Signals) -> None:
    effect, term = catalogue()["torque_lag/moment"], Term("torque_lag", "moment", (0.7,))
    passed = effect.passed(term, replace(signals, torque_noise_fraction=0.0))
    assert passed is not None
    assert passed.shape == (64,)
    assert passed[0] == pytest.approx(1.0, abs=1e-3)
    assert np.all(np.diff(passed) < 0.0)
    assert passed[-1] == pytest.approx(1.0 / (1.0 + (0.7 * np.pi / signals.block) ** 2), rel=0.02)
    assert effect.passed(term, replace(signals, torque_noise_fraction=1.0)) is None


def test_a_coupling_counts_from_zero_or_from_a_reference(signals: Signals) -> None:
    winch = catalogue(["winch"])["coupling:winch"]
    turned = replace(signals, channels={"winch": signals.channels["winch"] - 2.5})
    ((zero,),) = winch.starts(turned)
    assert zero == 0.0
    np.testing.assert_array_equal(winch.columns(turned, (zero,), ()), -turned.channels["winch"][:, None])
    assert winch.parameters(Term(winch.name, "", (3.0,), (zero,)), 350.0) == {"coefficient": 3.0}
    ((mean,),) = winch.starts(signals)
    assert mean == pytest.approx(2.0, abs=0.1)
    # 3 (x − 2) + 1.5 is 3 (x − 1.5)
    free = winch.parameters(Term(winch.name, "", (3.0, 1.5), (2.0,)), 350.0)
    assert free == {"coefficient": 3.0, "reference": 1.5}


def test_a_tether_is_untwisted_where_the_recording_began_or_at_heading_zero(signals: Signals) -> None:
    tether = catalogue()["tether"]
    seen = replace(signals, heading=signals.heading + 0.7)
    assert tether.starts(seen) == [(float(seen.heading[0]),), (0.0,)]
    for (neutral,) in tether.starts(seen):
        np.testing.assert_allclose(tether.columns(seen, (neutral,), ())[:, 0], seen.heading - neutral)


def test_every_effect_is_found_by_its_key() -> None:
    known = catalogue(["winch"])
    assert all(known[effect.key].sentence == effect.sentence for effect in EVERY)
    assert "thrust_efficiency" in known


@pytest.mark.parametrize("key", [e.key for e in EVERY if e.searched and e.name != "wave"])
def test_a_parameter_that_came_to_lie_beside_a_start_is_searched_beyond_it(key: str, signals: Signals) -> None:
    """It may have been held up there while another effect was not yet known."""
    effect = catalogue(["winch"])[key]
    starts = starts_of(effect, signals)
    ends = sorted({start[-1] for start in starts})
    below, at, above = ends[:3]
    head = starts[0][:-1]
    assert effect.bracket(signals, (*head, at)) == (below, above)
    assert effect.bracket(signals, (*head, at - 0.01 * (at - below))) == (below, above)
    assert effect.bracket(signals, (*head, 0.5 * (at + below))) == (below, at)


@pytest.mark.parametrize("sharpness", [2.0, 3.0, 4.0, 6.0, 10.0])
def test_limits_from_sharp_to_gradual_have_a_shape_in_the_catalogue(sharpness: float, signals: Signals) -> None:
    """a = u/(1 + |u/L|^p)^(1/p), the usual curve of amplifiers (C. Rapp, 1991), is met within 0.6 %."""
    command = np.linspace(-1.4, 1.4, 281)
    lost = command - command / (1.0 + np.abs(command) ** sharpness) ** (1.0 / sharpness)
    least = np.inf
    forms = [e for e in EVERY if isinstance(e, Saturation)]
    for form in forms:
        for width in {start[:-1] for start in form.starts(signals)}:
            for limit in np.linspace(0.4, 1.5, 111):
                shape = form.lost(command, (*width, float(limit)))
                weight = np.clip(float(shape @ lost) / max(float(shape @ shape), 1e-12), 0.5, 1.3)
                least = min(least, float(np.std(weight * shape - lost)))
    assert least < 0.006


def test_a_limit_just_above_the_commands_takes_but_their_noise(signals: Signals) -> None:
    limit = catalogue()["torque_saturation/limit"]
    largest = float(np.max(np.abs(signals.expected)))
    near, far = (Term(limit.name, limit.variant, (1.0,), (part * largest,)) for part in (0.995, 0.8))
    assert "no more than their noise" in limit.implausible(near, signals)
    assert limit.implausible(far, signals) == ""


@pytest.mark.parametrize("key", ["torque_saturation/limit", "dead_zone/shifted"])
def test_a_command_that_jumps_within_a_cell_loses_what_its_two_values_lose(key: str, signals: Signals) -> None:
    """The mean of the losses, which is not the loss of the mean."""
    effect = next(effect for effect in EVERY if effect.key == key)
    fine = np.repeat([30.0, 60.0, -60.0, 60.0, 5.0, -60.0], 120) + np.random.default_rng(8).normal(0.0, 0.1, 720)
    cells = fine[7:-1].reshape(-1, 8).mean(axis=1)  # the jumps fall within cells
    seen = replace(signals, expected=cells, predicted_torque=cells, uncertainty=0.0)
    of_cells = effect.columns(seen, (40.0,), ())[:, 0]
    of_values = effect.columns(
        replace(signals, expected=fine[7:-1], predicted_torque=fine[7:-1], uncertainty=0.0), (40.0,), ()
    )
    np.testing.assert_allclose(of_cells, of_values.reshape(-1, 8).mean(axis=1), atol=0.3)


@pytest.mark.parametrize(
    ("before", "after", "mean"), [(-0.1, 0.1, 0.0), (-0.1, 0.3, 0.5), (0.3, -0.1, 0.5), (0.1, 0.2, 1.0)]
)
def test_friction_acts_through_all_rates_that_a_reversal_passes(
    signals: Signals, before: float, after: float, mean: float
) -> None:
    """Four samples at one rate, then four at another: between them the moment changes its sign where the rate does."""
    rate = np.repeat([before, after], 4)
    seen = replace(signals, rate=rate, start=np.array([0, 8]), time=np.arange(8, dtype=np.float64))
    column = catalogue()["coulomb"].columns(seen, (1e-4,), ())[:, 0]
    acted = float(np.sum(0.5 * (column[1:] + column[:-1])))
    assert acted == pytest.approx(3.0 * np.sign(before) + 3.0 * np.sign(after) + mean, abs=1e-2)
