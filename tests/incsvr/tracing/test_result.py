"""A trace on the engine: what is found, what is proven, and the contract's form of both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.plant.words import YAW_WORDS
from incsvr.tracing.effects_found import sentence
from incsvr.tracing.findings import Trace
from incsvr.tracing.result import trace, trace_if_found
from incsvr.tracing.run import Run
from incsvr.tracing.sentences import headline
from service.fitting.trace import runs_of, text
from simulator.mission import Mission
from simulator.vehicles import TURNING
from simulator.world import play
from tests.incsvr.model.turning import Turning, dive, steered

KEYS = {
    "declared", "inertia", "verdict", "effects", "rejected", "unexplained", "error", "loop", "proven", "spans",
    "ignored_channels", "notes", "model",
}  # fmt: skip


def run_of(seed: int, trim: float = 0.0, begin: float = 0.0) -> Run:
    """A minute of a turning vehicle, on which a moment acts that is not in its log."""
    log = dive(Turning(inertia=12.0), seed, seconds=60.0, rate=5.0)
    time, torque = log["torque"]
    return Run(f"dive {seed}", begin + time, log["yaw_rate"][1], torque - trim)


@pytest.fixture(scope="module")
def trimmed() -> Trace:
    return trace([run_of(1, trim=1.5)], inertia=12.0, validate=[run_of(2, trim=1.5, begin=100.0)])


def test_a_hidden_moment_is_named_with_its_size_and_proven(trimmed: Trace) -> None:
    (effect,) = trimmed.effects
    assert effect.effect == "bias_torque"
    low, high = effect.interval["moment_nm"]
    assert low < 1.5 < high
    assert high - low < 0.5
    assert effect.p_value < 1e-9
    assert effect.share == 1.0
    assert "bias_drift" not in effect.cannot_tell_from  # it is the moment with a drift besides
    assert (trimmed.verdict, trimmed.loop, trimmed.proven) == ("effects", "open", True)
    assert "adding bias_torque lowers" in headline(trimmed)


def test_unseen_recordings_may_have_clocks_of_their_own() -> None:
    unseen = [run_of(2, trim=1.5), run_of(3, trim=1.5)]
    found = trace([run_of(1, trim=1.5)], inertia=12.0, validate=unseen)
    assert [each.effect for each in found.effects] == ["bias_torque"]


def test_the_result_has_the_contracts_form(trimmed: Trace) -> None:
    found = trimmed.to_dict()
    assert set(found) == KEYS
    error = found["error"]
    assert error["validated_on"] == "recordings"
    assert set(error["trivial"]) == {"zero", "hold", "output_error", "axis_alone"}
    assert error["best"] == {"name": "after", "free_run_rmse": error["after"]["free_run_rmse"]}
    assert error["after"]["free_run_rmse"] < 0.5 * error["before"]["free_run_rmse"]
    assert error["change"]["free_run_rmse"]["high"] < 0.0
    assert set(error["horizons"]) == {"0.5", "1", "2", "5"}
    assert [each["p_value"] for each in found["rejected"]] == sorted(each["p_value"] for each in found["rejected"])
    assert "bias_torque" not in {each["effect"] for each in found["rejected"]}
    assert found["model"]["effects"][0]["effect"] == "bias_torque"


def test_the_ledgers_parts_are_the_torque(trimmed: Trace) -> None:
    parts = trimmed.pictures.ledger
    assert set(parts) == {"declared inertia", "damping", "bias_torque"}
    torque = np.sum(list(parts.values()), axis=0)
    assert np.quantile(np.abs(torque), 0.9) == pytest.approx(10.5, rel=0.2)  # of a command of up to 12 N m either way
    assert parts["bias_torque"] == pytest.approx(trimmed.model.theta["bias_torque@yaw_rate"])


def test_a_vehicle_that_hardly_moves_is_refused() -> None:
    still = run_of(3)
    noise = np.random.default_rng(3).normal(0.0, 0.003, still.time.size)
    with pytest.raises(BadInput, match="too little motion"):
        trace([replace(still, yaw_rate=noise)], inertia=12.0)


def test_the_text_names_the_effect_with_its_unit(trimmed: Trace) -> None:
    assert "a constant yaw moment" in text(trimmed)
    assert "N m. It accounts for 100 % of the better fit." in text(trimmed)


def test_the_model_that_live_reads_has_the_engines_damping_and_effects(trimmed: Trace) -> None:
    moment = -trimmed.model.theta["bias_torque@yaw_rate"]
    assert moment == pytest.approx(trimmed.effects[0].parameters["moment_nm"], rel=0.05)
    at = np.array([0.2, 0.4])
    assert trimmed.model.damping_at(at) == pytest.approx(9.0 * at + 26.0 * at**2, rel=0.1)


def test_nothing_is_named_and_nothing_proven_where_nothing_is_hidden() -> None:
    found = trace([run_of(3)], inertia=12.0)
    assert (found.verdict, found.effects, found.proven) == ("none", (), False)
    assert found.error["after"] == found.error["before"]
    assert found.error["validated_on"] == "blocks"


def test_damping_that_differs_with_the_direction_is_learned_and_no_effect() -> None:
    log = dive(Turning(inertia=12.0), 4, rate=5.0)
    (time, torque), rate = log["torque"], log["yaw_rate"][1]
    found = trace([Run("uneven", time, rate, torque + 10.0 * rate**2)], inertia=12.0)
    assert (found.verdict, found.effects) == ("none", ())
    to_port, to_starboard = found.model.damping_at(np.array([-0.4, 0.4]))
    assert to_starboard + to_port == pytest.approx(2.0 * 10.0 * 0.4**2, rel=0.15)


@pytest.mark.parametrize(
    ("effect", "parameter", "size", "thrust"),
    [
        ("dead_zone", "half_width_nm", 2.0, lambda asked: asked if abs(asked) > 2.0 else 0.0),
        ("dead_zone", "half_width_nm", 2.0, lambda asked: asked - max(min(asked, 2.0), -2.0)),
        ("torque_saturation", "limit_nm", 8.0, lambda asked: max(min(asked, 8.0), -8.0)),
        ("torque_saturation", "limit_nm", 8.0, lambda asked: asked / (1.0 + abs(asked / 8.0) ** 3.5) ** (1.0 / 3.5)),
    ],
    ids=["jumps", "begins at nothing", "is cut", "bends"],
)
def test_a_dead_zone_and_a_limit_are_named_alone_in_either_shape(
    effect: str, parameter: str, size: float, thrust: Callable[[float], float]
) -> None:
    log = dive(Turning(inertia=12.0, thrust=thrust), 6, seconds=240.0, rate=5.0)
    found = trace([Run(effect, *log["yaw_rate"], log["torque"][1])], inertia=12.0)
    assert [each.effect for each in found.effects] == [effect]
    assert found.effects[0].parameters[parameter] == pytest.approx(size, rel=0.1)


def test_live_gets_the_same_effects(trimmed: Trace) -> None:
    found = trace_if_found([run_of(1, trim=1.5)], inertia=12.0)
    assert found is not None
    assert [each.to_dict() for each in found.effects] == [each.to_dict() for each in trimmed.effects]


def test_another_inertia_is_named_with_what_no_manoeuvre_tells_from_it() -> None:
    found = trace([run_of(3)], inertia=7.0)
    (effect,) = found.effects
    assert effect.effect == "inertia"
    low, high = effect.interval["inertia_kg_m2"]
    assert low < 12.0 < high
    assert effect.cannot_tell_from == ("thrust_efficiency",)
    assert "no manoeuvre in yaw" in effect.next_manoeuvre
    assert found.proven


def test_in_closed_loop_predictions_of_the_next_sample_prove_an_effect() -> None:
    """The log is of a controller that answers the water."""
    log = steered(Turning(), 3)
    time, torque = log["torque"]
    found = trace([Run("steered", time, log["yaw_rate"][1], torque - 3.0)], inertia=24.0)
    assert [effect.effect for effect in found.effects] == ["bias_torque"]
    assert (found.loop, found.proven) == ("closed", True)
    assert found.error["change"]["torque_rmse"]["high"] < 0.0
    assert found.error["after"]["torque_rmse"] < found.error["before"]["torque_rmse"]


def test_a_curve_that_no_effect_has_is_unexplained_and_gains_nothing() -> None:
    log = dive(Turning(inertia=12.0), 4, seconds=180.0, rate=5.0)
    (time, torque), arm = log["torque"], log["surge"][1]
    hidden = 4.0 * np.cos(2.5 * (arm - 0.8))
    hidden -= hidden.mean()  # a moment would be an effect
    found = trace([Run("arm", time, log["yaw_rate"][1], torque - hidden, {"arm": arm})], inertia=12.0)
    assert [each.channel for each in found.unexplained] == ["arm"]
    assert (found.verdict, found.effects) == ("unexplained", ())
    assert found.error["after"] == found.error["before"]
    assert headline(found) == "no known effect explains how the residual follows arm"


def test_live_gets_nothing_where_nothing_is_hidden() -> None:
    assert trace_if_found([run_of(3)], inertia=12.0) is None


@pytest.mark.parametrize("seed", [3, pytest.param(5, marks=pytest.mark.slow)])
def test_a_controller_that_answers_the_water_is_a_closed_loop(seed: int) -> None:
    log = steered(Turning(), seed)
    found = trace([Run("steered", log["torque"][0], log["yaw_rate"][1], log["torque"][1])], inertia=24.0)
    assert (found.loop, found.verdict) == ("closed", "none")


def test_recordings_with_stamps_that_overlap_have_no_clock() -> None:
    found = trace([run_of(3), run_of(4)], inertia=12.0)
    assert not found.one_clock
    assert not {each.effect for each in found.rejected} & {"bias_drift", "drag_drift", "drag_step", "wave"}


def test_a_negative_delay_is_called_impossible() -> None:
    said = sentence("delay@yaw_rate", {"delay_s": -0.3}, {"delay_s": (-0.4, -0.2)}, 0.5, YAW_WORDS)
    assert "which is impossible" in said
    assert said.endswith("delay -0.3 (-0.4 to -0.2) s. It accounts for 50 % of the better fit.")


@pytest.mark.slow
@pytest.mark.parametrize(("name", "key"), [("torque_delay", "delay_s"), ("drag_drift", "fraction")])
def test_a_hidden_effect_of_a_mission_is_traced(name: str, key: str) -> None:
    outcome = play(Mission(TURNING["auv"], "telegraph", 990_050, hidden=(name,), duration=240.0))
    found = trace(runs_of([outcome.recording]), inertia=outcome.inertia)
    (effect,) = found.effects
    assert (effect.effect, found.proven) == (name, True)
    low, high = effect.interval[key]
    assert low - (high - low) < float(outcome.truth[name][key]) < high + (high - low)
