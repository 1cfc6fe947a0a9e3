"""Products of two velocities: found where they act, told from what a yaw tracer would name instead, absent else."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.effects import Term, candidates, catalogue
from incsvr.effects.signals import Signals
from incsvr.numerics import Array
from incsvr.plant.axes import AXES, products
from incsvr.tracing import Run, trace
from incsvr.tracing.model import TracedModel

STEP, INERTIA, MUNK, LIFT = 0.1, 24.0, 30.0, 40.0


def wandering(random: np.random.Generator, count: int, lag: float, size: float) -> Array:
    """A velocity that wanders with this time constant [s]."""
    noise, values = random.normal(0.0, 1.0, count), np.zeros(count)
    for k in range(1, count):
        values[k] = values[k - 1] + STEP / lag * (noise[k] - values[k - 1])
    return np.asarray(size * values / np.std(values))


def boat(seed: int, munk: float = 0.0, lift: float = 0.0, count: int = 1500) -> Run:
    """Yaw of a vehicle that surges and sways: I ṙ + 9 r + 26 r|r| + munk u v + lift (u − 0.6) r = τ."""
    random = np.random.default_rng(seed)
    surge, sway = 0.6 + wandering(random, count, 4.0, 0.3), wandering(random, count, 3.0, 0.25)
    torque = np.repeat(random.uniform(-12.0, 12.0, count // 30), 30)
    water = wandering(random, count, 0.5, 0.3)
    rate = np.zeros(count)
    for k in range(count - 1):
        r = rate[k]
        for _ in range(4):
            moment = torque[k] + water[k] - 9.0 * r - 26.0 * r * abs(r)
            moment -= munk * surge[k] * sway[k] + lift * (surge[k] - 0.6) * r
            r += 0.25 * STEP / INERTIA * moment
        rate[k + 1] = r
    time: Array = STEP * np.arange(count, dtype=np.float64)
    rate += random.normal(0.0, 0.002, count)
    return Run(f"boat {seed}", time, rate, torque, {"surge": surge, "sway": sway})


def test_the_product_that_acts_is_named_with_its_ratio() -> None:
    found = trace([boat(1, MUNK)], inertia=INERTIA, validate=[boat(2, MUNK)])
    first = found.effects[0]
    assert first.effect == "coriolis:surge*sway"
    low, high = first.interval["coefficient"]
    assert 0.8 * MUNK < low < high < 1.2 * MUNK
    assert first.parameters["ratio"] == pytest.approx(first.parameters["coefficient"] / INERTIA)
    assert found.error["after"]["free_run_rmse"] < 0.5 * found.error["before"]["free_run_rmse"]
    assert found.proven


def test_nothing_is_named_where_no_product_acts() -> None:
    assert trace([boat(3)], inertia=INERTIA, validate=[boat(4)]).verdict == "none"


def test_a_product_with_the_own_rate_is_told() -> None:
    """m x_g u r."""
    found = trace([boat(5, lift=LIFT)], inertia=INERTIA, torque="commanded")
    (own,) = found.effects
    assert "coriolis:surge*yaw_rate" in (own.effect, *own.cannot_tell_from)


def test_each_axis_has_the_products_of_its_row() -> None:
    planar = ("surge", "sway", "yaw_rate")
    rows = {name: products(axis, planar) for name, axis in AXES.items()}
    assert ("surge", "yaw_rate") in rows["sway"]
    assert ("sway", "yaw_rate") in rows["surge"]
    assert ("surge", "sway") in rows["yaw"]
    assert ("yaw_rate", "yaw_rate") in rows["surge"]
    assert ("yaw_rate", "yaw_rate") not in rows["yaw"]
    assert products(AXES["yaw"], ("voltage",)) == ()
    names = [effect.name for effect in candidates(("surge", "yaw_rate"), "sway")]
    assert names.count("coriolis:surge*yaw_rate") == 1
    assert "coriolis:surge*sway" in names


@pytest.mark.parametrize("own", ["", "yaw_rate"])
def test_a_saved_product_is_read_back_and_runs_on_the_simulated_rate(own: str) -> None:
    """Without thrust the product with the own rate keeps a resting vehicle at rest, whatever was measured."""
    second = own or "sway"
    term = Term(f"coriolis:surge*{second}", own, (5.0,))
    rates = np.linspace(-1.0, 1.0, 21)
    model = TracedModel(2.0, rates, 3.0 * rates, (term,), 1.0, 0.3, 2.0, (0.0, 20.0))
    again = TracedModel.from_dict(model.to_dict())
    assert [effect.key for effect in again.effects()] == [f"{term.effect}/{own}" if own else term.effect]
    count = 200
    measured, still = np.full(count, 0.4), np.zeros(count)
    measured[0] = 0.0
    signals = Signals(
        step=STEP, start=np.array([0, count]), time=np.linspace(0.0, STEP * (count - 1), count), rate=measured,
        heading=still, torque=still, channels={"surge": np.ones(count), "sway": np.ones(count)},
    )  # fmt: skip
    _, simulated = again.simulate(signals)
    if own:
        np.testing.assert_allclose(simulated, 0.0, atol=1e-12)
    else:  # 2 ṙ + 3 r + 5 = 0
        assert simulated[-1] == pytest.approx(-5.0 / 3.0, rel=0.5)
    assert f"coriolis:surge*{second}" in {effect.name for effect in catalogue([f"surge*{second}"]).values()}
