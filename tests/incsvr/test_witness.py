"""Free runs that are driven by a plain command see none of the torque's noise: they tell what the equation hints at."""

from __future__ import annotations

import pytest

from incsvr.effects import catalogue
from incsvr.tracer.alignment import aligned
from incsvr.tracer.asked import WITNESSED
from incsvr.tracer.hypothesis import nothing, settle
from incsvr.tracer.proof import Court
from simulator.trial import Trial, play
from tests.incsvr.trials import as_run, named


def test_friction_of_which_the_equation_holds_but_a_hint_is_found() -> None:
    hidden = ("coulomb", "dead_zone")
    assert named(play(Trial(435_104, hidden, 1.0, "small", "telegraph", 0.0, noise="torque"))) == set(hidden)


def test_fewer_effects_that_run_as_well_are_named() -> None:
    """A dead band and a limit together scale the thrust, as another inertia does, and take some of its noise."""
    assert named(play(Trial(445_041, ("inertia",), 1.0, "small", "telegraph", 0.5, noise="torque"))) == {"inertia"}


@pytest.mark.parametrize(
    ("excitation", "witness"),
    [("telegraph", True), ("multisine", False), ("closed_loop", False)],
)
def test_they_are_no_witness_of_tones_or_of_a_controller(excitation: str, witness: bool) -> None:
    """What noise makes of a tone is in the equation and in the command; a controller's torque is no plain command."""
    outcome = play(Trial(7, (), 1.0, "leng", excitation, 0.5, 360.0, noise="torque"))
    problem, _ = aligned([as_run(outcome)], outcome.inertia, [])
    assert Court.of(problem, None, quick=True).witness is witness
    assert not Court.of(problem, None, quick=True, finer=True).witness


def test_noise_that_lasts_feigns_no_effect_of_tones() -> None:
    assert named(play(Trial(445_055, (), 1.0, "small", "multisine", 0.98, noise="torque"))) == set()


def test_what_makes_up_for_another_effects_doubt_is_not_needed() -> None:
    """The torque's noise has moved the reverse thrust; a bias runs better beside it, and no better once it is right."""
    outcome = play(Trial(465_045, ("torque_asymmetry",), 0.5, "small", "telegraph", 0.9, noise="torque"))
    problem, _ = aligned([as_run(outcome)], outcome.inertia, [])
    court, known = Court.of(problem, None, quick=True), catalogue()
    terms = [(known["torque_asymmetry"], (), ()), (known["bias_torque"], (), ())]
    alone, both = (settle(problem, terms[:n], nothing(problem)) for n in (1, 2))
    assert court.tells(both, alone) > WITNESSED
    assert court.needs(both, alone) < 0.0
    assert named(outcome) == {"torque_asymmetry"}


def test_what_free_runs_need_is_named_though_the_equation_but_hints_at_it() -> None:
    hidden = ("coulomb", "drag_step")
    assert named(play(Trial(465_068, hidden, 1.0, "small", "telegraph", 0.9, noise="torque"))) == set(hidden)


def test_a_limit_of_a_command_of_few_levels_is_no_inertia() -> None:
    """A limit with a rounder corner, less inertia and less drag: the same motion, with less of the jumps' instants."""
    hidden = ("modulation:temperature", "torque_saturation")
    assert named(play(Trial(465_050, hidden, 1.0, "leng", "telegraph", 0.9, noise="torque"))) == set(hidden)


def test_a_plainly_better_free_run_tells_an_inertia_from_another_delay() -> None:
    hidden = ("torque_delay", "inertia")
    assert named(play(Trial(465_031, hidden, 1.0, "small", "multisine", 0.9, noise="torque"))) == set(hidden)
