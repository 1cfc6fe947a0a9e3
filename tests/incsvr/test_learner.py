"""One iteration as a value, under both policies, over one velocity and over several."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from incsvr.errors import BadInput
from incsvr.learning.learner import Iteration, Settings, State, Waiting, start, step, under_policy
from incsvr.learning.model import Model
from incsvr.signals.samples import Samples
from tests.incsvr.learning import (
    HULL,
    OTHERS,
    Policy,
    among_others,
    batches,
    drag,
    kinds,
    of,
    policies,
    rms,
    run,
    stream,
)

RATES = np.linspace(-0.24, 0.24, 49)


def plain(value: Any) -> str:
    """Everything in a state or iteration, to the bit."""
    return json.dumps(value, default=lambda array: array.tolist())


def columns(samples: Samples) -> list[Any]:
    return [samples.time, samples.yaw_rate, samples.damping, *samples.channels.values()]


def as_text(iteration: Iteration) -> str:
    fields = {name: getattr(iteration, name) for name in Iteration.__slots__}
    model = fields.pop("model").to_dict()
    samples = {name: columns(part) for name, part in fields.items() if isinstance(part, Samples)}
    rest = {name: part for name, part in fields.items() if not isinstance(part, Samples)}
    return plain([model, samples, rest])


def goes_on_to_the_bit(settings: Settings, samples: Samples) -> None:
    """A state that is written and read before every batch gives the same iterations as one that is not."""
    straight, resumed = start(settings), start(settings)
    for batch in batches(samples):
        straight, expected = step(settings, straight, batch)
        resumed, found = step(settings, State.from_dict(json.loads(json.dumps(resumed.to_dict()))), batch)
        assert as_text(found) == as_text(expected)
        assert plain(resumed.to_dict()) == plain(straight.to_dict())


@kinds
def test_a_state_from_a_file_goes_on_to_the_bit(settings: Settings) -> None:
    """With a hull, so that evidence, open correction and the vectors from before it are in the state as well."""
    goes_on_to_the_bit(settings, of(settings, stream(3, 700, hull_from=400)))


@pytest.mark.slow
@policies
def test_a_state_of_the_passes_of_eq_8_goes_on_to_the_bit(policy: Policy) -> None:
    goes_on_to_the_bit(Settings(policy=policy, solver="passes"), stream(3, 100))


@kinds
def test_a_step_changes_nothing_that_it_was_given(settings: Settings) -> None:
    state, _ = run(settings, of(settings, stream(4, 800, hull_from=600)))
    batch = of(settings, stream(5, 50))
    before, samples = plain(state.to_dict()), plain(columns(batch))
    step(settings, state, batch)
    assert plain(state.to_dict()) == before
    assert plain(columns(batch)) == samples


@pytest.mark.slow
@kinds
def test_memory_is_bounded(settings: Settings) -> None:
    long = 1800 if settings.others else 3000
    state, iterations = run(settings, of(settings, stream(6, long, hull_from=long // 2)))
    assert max(iteration.model.weight.size for iteration in iterations) <= settings.capacity
    sizes = [len(json.dumps(each.to_dict())) for each in (run(settings, of(settings, stream(6, long // 3)))[0], state)]
    assert sizes[1] < 2 * sizes[0]


@kinds
def test_every_sample_of_a_batch_is_accounted_for(settings: Settings) -> None:
    for iteration in run(settings, of(settings, stream(7, 600, wild=0.1)))[1]:
        parts = [iteration.new, iteration.discarded_tube, iteration.discarded_near, iteration.undriven]
        if settings.policy == "weighted":  # the paper's outliers are support vectors, new or old
            parts.append(iteration.outliers)
        assert sum(len(part) for part in parts) == 50
        assert len(np.unique(np.concatenate([part.time for part in parts]))) == 50


@kinds
def test_the_progressive_error_is_the_error_before_learning(settings: Settings) -> None:
    state, _ = run(settings, of(settings, stream(8, 400)))
    batch = of(settings, stream(9, 50))
    expected = float(np.abs(state.model.at(batch).damping - batch.damping).mean())
    assert step(settings, state, batch)[1].progressive_mae == pytest.approx(expected, rel=1e-12)
    assert step(settings, start(settings), batch)[1].progressive_mae is None


@kinds
def test_an_outlier_is_thrown_out(settings: Settings) -> None:
    state, _ = run(settings, of(settings, stream(8, 600)))
    batch = of(settings, stream(9, 50, wild=0.0))
    far = int(np.argmax(np.abs(batch.yaw_rate)))  # where the torque, not the water, turns it
    wild = replace(batch, damping=batch.damping + np.where(np.arange(50) == far, 150.0, 0.0))
    _, iteration = step(settings, state, wild)
    assert batch.time[far] in iteration.outliers.time


@policies
def test_the_hull_is_learned(policy: Policy) -> None:
    _, iterations = run(Settings(policy=policy), stream(10, 1400, hull_from=700))
    bare = rms(iterations[13].model.evaluate(RATES) - drag(RATES))
    hulled = rms(iterations[-1].model.evaluate(RATES) - (1.0 + HULL) * drag(RATES))
    stale = rms(iterations[13].model.evaluate(RATES) - (1.0 + HULL) * drag(RATES))
    assert bare < 3.0
    assert hulled < 3.0
    assert stale > 4.0  # so that the two lines above could fail


@kinds
def test_the_certificate_is_in_every_model(settings: Settings) -> None:
    for seed in range(3):
        samples = of(settings, stream(20 + seed, 900, hull_from=450, wild=0.05))
        for iteration in run(settings, samples)[1]:
            assert 0.0 <= iteration.model.certified_error <= 0.01


@kinds
def test_the_noise_level_is_found(settings: Settings) -> None:
    for sigma in (1.0, 4.0):
        state, _ = run(settings, of(settings, stream(30, 1000, sigma=sigma, wild=0.03)))
        assert state.model.sigma == pytest.approx(sigma, rel=0.25)


@policies
def test_a_served_sigma_follows_the_rate(policy: Policy) -> None:
    samples = stream(21, 700, wild=0.0)
    noise = samples.damping - drag(samples.yaw_rate)
    samples.damping[:] = drag(samples.yaw_rate) + noise * (0.5 + 4.0 * np.abs(samples.yaw_rate))
    model = run(Settings(policy=policy), samples)[0].model
    quiet, loud = model.predict([0.02, 0.23]).sigma
    assert 1.6 < quiet < 3.5
    assert 4.5 < loud < 8.0


# Sixty-fourths of a rate and quarters of a moment make ties; a thousand quarters make outliers.
odd_batches = st.lists(
    st.lists(st.tuples(st.integers(-20, 20), st.integers(-400, 400) | st.just(4000)), min_size=1, max_size=70),
    min_size=1,
    max_size=8,
)


@policies
@hypothesis.settings(max_examples=40)
@hypothesis.given(parts=odd_batches)
def test_whatever_comes_is_learned_within_bounds(policy: Policy, parts: list[list[tuple[int, int]]]) -> None:
    settings, time = Settings(policy=policy), 0.0
    state = start(settings)
    for part in parts:
        rate, damping = np.array(part, dtype=np.float64).T / np.array([[64.0], [4.0]])
        batch = Samples(time + np.linspace(1.0, len(part), len(part)), rate, damping)
        time = float(batch.time[-1])
        state, iteration = step(settings, state, batch)
        assert iteration.model.weight.size <= settings.capacity
        if iteration.model.is_trained:
            said = iteration.model.predict(np.array([-0.3, 0.0, 0.1, 5.0]))
            assert np.isfinite([*said.damping, *said.sigma]).all()
        assert np.isfinite(iteration.model.weight).all()
        assert 0.0 <= iteration.model.certified_error <= 0.01
        assert iteration.number == state.iterations
        json.dumps(state.to_dict(), allow_nan=False)


@pytest.mark.parametrize(
    ("batch", "cure"),
    [
        (Samples.empty(), "wait for more"),
        (Samples(np.zeros(1), np.array([np.nan]), np.zeros(1)), "reject them"),
        (Samples(np.zeros(1), np.zeros(1), np.array([np.inf])), "reject them"),
    ],
)
def test_a_batch_that_cannot_be_learned_is_refused(batch: Samples, cure: str) -> None:
    with pytest.raises(BadInput, match=cure):
        step(Settings(), start(Settings()), batch)


def test_a_state_of_another_policy_or_form_is_refused() -> None:
    state = start(Settings(policy="paper"))
    with pytest.raises(BadInput, match='policy "paper"'):
        step(Settings(policy="weighted"), state, stream(1, 50))
    with pytest.raises(BadInput, match="empty state directory"):
        State.from_dict(state.to_dict() | {"form": 0})


@policies
def test_under_another_policy_what_was_learned_goes_on(policy: Policy) -> None:
    after = Settings(policy="weighted" if policy == "paper" else "paper")
    samples = stream(10, 1050)
    before, _ = run(replace(after, policy=policy), samples.take(slice(0, 1000)))
    taken = under_policy(after, before)
    assert (taken.iterations, taken.model) == (before.iterations, before.model)
    ours, theirs = (np.sort(each.memory.served.damping) for each in (taken, before))
    np.testing.assert_array_equal(ours, theirs)
    state, iteration = step(after, taken, samples.take(slice(1000, None)))
    assert (state.policy, iteration.number) == (after.policy, 21)
    # fifty samples alone leave three times as much
    assert rms(state.model.predict(RATES).damping - drag(RATES)) < 1.1 * rms(
        before.model.predict(RATES).damping - drag(RATES)
    )


def test_a_state_of_the_paper_over_several_velocities_goes_on_under_weighted() -> None:
    """Versions before 2026-11-28 wrote such states; they keep no weights."""
    samples = among_others(stream(10, 150))
    before, _ = run(Settings(policy="paper"), stream(10, 100))
    data = before.to_dict()
    memory = {name: value for name, value in data["memory"].items() if name != "weight"}
    old = samples.take(np.searchsorted(samples.time, before.memory.served.time))
    others = {name: values.tolist() for name, values in old.channels.items()}
    memory |= {name: getattr(old, name).tolist() for name in ("time", "yaw_rate", "damping")}
    memory |= {"others": others, "stays": [True] * len(old), "fastest": [1.0, 0.2]}
    after = Settings(policy="weighted", others=OTHERS)
    taken = under_policy(
        after, State.from_dict(data | {"memory": memory, "model": Model.untrained(10.0, 1e3, 0.1).to_dict()})
    )
    state, _ = step(after, replace(taken, waiting=Waiting()), samples.take(slice(100, None)))
    assert taken.memory.served.channels.keys() == {"surge", "sway"}
    assert state.model.several is not None
    assert state.model.count.sum() > 100  # the old vectors and the new batch


@pytest.mark.parametrize(
    ("wrong", "cure"),
    [
        ({"gamma": 0.0}, "above 0"),
        ({"capacity": -1}, "above 0"),
        ({"epsilon": -0.1}, "0 or more"),
        ({"rate_range": (0.25, -0.25)}, "lower end first"),
        ({"policy": "newest"}, "choose"),
        ({"solver": "smo"}, "choose"),
        ({"C": float("nan")}, "above 0"),
    ],
)
def test_settings_that_make_no_sense_are_refused(wrong: dict[str, Any], cure: str) -> None:
    with pytest.raises(BadInput, match=cure):
        Settings(**wrong)
