"""The search names what is there, in the fewest effects that say it."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects import candidates, catalogue
from incsvr.tracing.weak.hypothesis import Hypothesis, nothing, settle
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.required_gain import LEAST_GAIN, penalised_criterion
from incsvr.tracing.weak.scan import best_leads, with_lead
from incsvr.tracing.weak.search import Search
from incsvr.tracing.weak.validation import Validation
from tests.incsvr.turning import INERTIA, command, instants, turning

TIME = instants(400.0)
SWAY = 0.1 * np.sin(0.3 * TIME) + 0.05 * np.sin(TIME / 31.0) + 0.03
VOLTAGE = 16.0 - 2.0 * TIME / TIME[-1] + 0.2 * np.sin(TIME / 5.0)
FULL = 16.0
"""The level at which the thrust table was measured, and with which the recording begins [V]."""


def search(problem: Problem) -> Search:
    return Search(problem, candidates(problem.signals.channels), Validation.of(problem, None, quick=True))


def parameters(found: Hypothesis) -> dict[str, dict[str, float]]:
    return {e.key: e.parameters(t, INERTIA) for e, t in zip(found.effects, found.terms, strict=True)}


def test_nothing_is_named_where_nothing_is_hidden() -> None:
    assert search(turning(0, command(0, TIME), channels={"sway": SWAY})).run().terms == ()


def test_a_coupling_that_passes_through_zero_leaves_the_bias_to_itself() -> None:
    problem = turning(0, command(0, TIME), outside=12.0 + 150.0 * SWAY, channels={"sway": SWAY})
    found = parameters(search(problem).run())
    assert set(found) == {"coupling:sway", "bias_torque"}
    assert found["coupling:sway"] == {"coefficient": pytest.approx(150.0, rel=0.05)}
    assert found["bias_torque"]["moment_nm"] == pytest.approx(12.0, rel=0.1)


def test_a_coupling_that_never_does_finds_its_reference() -> None:
    """The constant moment is that of the channel's distance from its reference: no effect of its own."""
    problem = turning(0, command(0, TIME), outside=20.0 * (VOLTAGE - 14.5), channels={"voltage": VOLTAGE})
    found = parameters(search(problem).run())
    assert set(found) == {"coupling:voltage"}
    assert found["coupling:voltage"]["coefficient"] == pytest.approx(20.0, rel=0.1)
    assert found["coupling:voltage"]["reference"] == pytest.approx(14.5, abs=0.1)


@pytest.fixture(scope="module", params=[0, 1])
def sagging(request: pytest.FixtureRequest) -> Problem:
    """The thrust falls with the voltage: 15 % a volt below a full battery."""
    seed: int = request.param
    gain = 1.0 + 0.15 * (VOLTAGE - FULL)
    return turning(seed, command(seed, TIME), gain=gain, channels={"voltage": VOLTAGE})


def test_a_thrust_scaled_about_its_starting_value_is_one_effect(sagging: Problem) -> None:
    found = parameters(search(sagging).run())
    assert set(found) == {"modulation:voltage/thrust, own level"}
    (values,) = found.values()
    assert values["coefficient"] == pytest.approx(0.15, rel=0.1)
    assert values["reference"] == pytest.approx(FULL, abs=0.25)


def test_a_dead_band_outside_which_every_command_lies_has_its_true_width() -> None:
    """Its width and the part that is lost inside would stand for each other: inside, all is lost."""
    levels = 80.0 * np.sign(command(0, TIME)) * np.where(np.abs(command(0, TIME)) > 45.0, 1.0, 0.55)
    gain = 1.0 - 8.0 / np.abs(levels)
    found = parameters(search(turning(0, levels, gain=gain)).run())
    assert set(found) == {"dead_zone/shifted"}
    assert found["dead_zone/shifted"]["half_width_nm"] == pytest.approx(8.0, rel=0.15)


def test_thrust_that_falls_short_at_the_top_is_no_lighter_vehicle() -> None:
    """A steeper loss, a smaller inertia and less drag explain as much with less noise, if its scale were free."""
    levels = 80.0 * np.sign(command(0, TIME)) * np.where(np.abs(command(0, TIME)) > 45.0, 1.0, 0.55)
    gain = np.minimum(1.0, 55.0 / np.abs(levels))
    found = parameters(search(turning(0, levels, gain=gain)).run())
    assert {key.split("/")[0] for key in found} == {"torque_saturation"}


def test_a_tether_and_a_bias_that_hide_each_other_are_found() -> None:
    """Alone the tether leaves a constant, and noise whose colour holds both explains more than that."""
    problem = turning(0, command(0, TIME), outside=20.0, stiffness=1.5)
    alone = settle(problem, [(catalogue()["tether"], (0.0,), ())], nothing(problem))
    assert penalised_criterion(alone) < penalised_criterion(nothing(problem)) - LEAST_GAIN
    assert set(search(problem).run().names()) == {"tether", "bias_torque"}


def test_an_effect_that_promises_from_two_starts_is_settled_from_both() -> None:
    """Beside a wave the second start of a dead band leads further than the first, which the AR's memory prefers."""
    asked = command(4, TIME)
    swell = 12.0 * np.sin(2.0 * np.pi * TIME / 9.65)
    problem = turning(4, asked, gain=np.where(np.abs(asked) > 15.0, 1.0, 0.0), outside=swell)
    wave = catalogue()["wave"]
    base = settle(problem, [(wave, (9.65,), ())], nothing(problem), frozenset({wave.key}))
    bands = [effect for effect in candidates([]) if effect.name == "dead_zone"]
    leads = [lead for lead in best_leads(problem, base, bands, 9) if lead.effect.variant == "step"]
    assert len(leads) == 2
    reached = [penalised_criterion(with_lead(problem, base, lead)) for lead in leads]
    assert reached[1] > reached[0] + 1.0
    hunt = Search(problem, bands, Validation.of(problem, None, quick=True))
    (grown,) = hunt._grown([base], 9)
    assert penalised_criterion(grown) == pytest.approx(max(reached))
