"""The study of measured vehicles: its simulations where the answer is known, and a split of it end to end."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.study import MEASURED
from benchmarks.vehicles import __main__ as vehicles
from benchmarks.vehicles import peers as vehicle_peers
from benchmarks.vehicles.motion import Integrated, Trivial
from benchmarks.vehicles.peers import frols, sindy
from benchmarks.vehicles.splits import SPLITS, Split
from incsvr.effects import Signals
from incsvr.numerics import Array

STEP, COUNT = 0.1, 1200


@pytest.fixture(autouse=True)
def few_candidates(monkeypatch: pytest.MonkeyPatch) -> None:
    """The study tries more thresholds and numbers of terms than a test has time for."""
    monkeypatch.setattr(vehicle_peers, "THRESHOLDS", (0.03, 0.1))
    monkeypatch.setattr(vehicle_peers, "TERMS", (4, 6))
    monkeypatch.setattr(vehicle_peers, "MOST_SAMPLES", 100)


@pytest.fixture(scope="module")
def driven() -> Signals:
    """ṙ = 0.5 τ − 0.8 r − 0.6 u v with steps of τ that hold, two runs of it."""
    random = np.random.default_rng(900_100)
    torque = np.repeat(random.uniform(-1.0, 1.0, COUNT // 12), 12)
    time: Array = STEP * np.arange(COUNT, dtype=np.float64)
    surge, sway = np.sin(0.3 * time) + 0.4 * np.sin(1.1 * time), np.cos(0.47 * time)
    rate, kept = np.zeros(COUNT), np.exp(-0.8 * STEP)
    for k in range(COUNT - 1):
        rate[k + 1] = kept * rate[k] + (1.0 - kept) / 0.8 * (0.5 * torque[k] - 0.6 * surge[k] * sway[k])
    start = np.array([0, COUNT // 2, COUNT], dtype=np.intp)
    return Signals(STEP, start, time, rate, torque, {"surge": surge, "sway": sway}, scale=1.5)


def test_a_known_acceleration_is_integrated_from_the_first_velocity_of_each_span(driven: Signals) -> None:
    model = Integrated(lambda r, t, o: 0.5 * t - 0.8 * r - 0.6 * o[:, 0] * o[:, 1], ("surge", "sway"), 10.0)
    for spans in (None, [slice(100, 151), slice(700, 900)]):
        index, simulated = model.simulate(driven, spans=spans)
        measured = driven.pieces(driven.runs() if spans is None else spans).rate
        np.testing.assert_allclose(simulated, measured[index], atol=1e-6)
    assert np.all(Trivial(1.0).simulate(driven, spans=[slice(100, 151)])[1] == driven.rate[100])


def test_the_libraries_find_the_product_of_two_velocities(driven: Signals) -> None:
    for learned in (sindy(driven, ("surge", "sway")), frols(driven, ("surge", "sway"))):
        _, simulated = learned.simulate(driven)
        assert np.sqrt(np.mean((simulated - driven.rate) ** 2)) < 0.1 * np.std(driven.rate)


def test_a_narx_model_runs_as_its_library_runs_it(driven: Signals) -> None:
    """sysidentpy's own free run, from its own first values, against ours over a span that begins there."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS

    found = frols(driven, ("surge", "sway"))
    model = FROLS(order_selection=False, n_terms=4, ylag=2, xlag=[[1, 2]] * 3, basis_function=Polynomial(degree=2))
    hop, first = found.hop, 60
    at = first + hop * np.arange(40)
    whole = np.zeros_like(at), np.full_like(at, COUNT)
    inputs = np.column_stack([driven.torque, driven.channels["surge"], driven.channels["sway"]])
    pushed = found.mean_input(inputs, at, *whole)
    measured = driven.rate[at, None] / found.deviation[0]
    model.fit(X=pushed, y=measured)
    model.final_model, model.theta, model.n_terms = found.terms, found.theta[:, None], len(found.terms)
    theirs = np.ravel(model.predict(X=pushed, y=measured[:2]))
    index, ours = found.simulate(driven, spans=[slice(int(at[1]), int(at[-1]) + 1)])
    np.testing.assert_allclose(ours[::hop], theirs[1:] * found.deviation[0], atol=1e-9)
    assert index.size == at[-1] - at[1] + 1


def test_no_recording_is_fitted_and_judged_on() -> None:
    for split in SPLITS:
        assert not set(split.fitted) & set(split.unseen), split.name


def test_a_measured_split_runs_end_to_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if not (MEASURED / "dagon").is_dir():
        pytest.skip("the measured recordings are not in ../shared/measured")
    short = Split("dagon", "sway", 2500.0, "", ("run_05",), ("run_07",), mass_matrix="2200,2500,0,0,0,0")
    monkeypatch.setattr(vehicles, "SPLITS", (short,))
    assert vehicles.main(["--out", str(tmp_path)]) == 0
    document = json.loads((tmp_path / "vehicles.json").read_text(encoding="utf-8"))
    (record,) = document["splits"]
    rows = record["rows"]
    assert set(rows) == {*vehicles.METHODS, vehicles.IN_BODY, "incsvr trace"}
    assert "the axis is coupled to others" in rows["incsvr fit"]["failed"]
    assert rows[vehicles.IN_BODY]["free_run"] < 0.5 * rows["least squares"]["free_run"]
    assert all(set(row["ahead"]) == {"0.5", "1", "2", "5"} for row in rows.values() if "failed" not in row)
    # Holding the last velocity errs less half a time scale ahead than two; zero errs by the velocity itself.
    assert rows["hold"]["ahead"]["0.5"] < rows["hold"]["ahead"]["2"]
    assert rows["zero"]["free_run"] == pytest.approx(rows["zero"]["ahead"]["0.5"], rel=0.1)
    assert record["trace"]["after"] == pytest.approx(rows["incsvr trace"]["free_run"], rel=0.1)
    text = (tmp_path / "vehicles.md").read_text(encoding="utf-8")
    assert all(name in text for name in rows)


def test_recordings_that_are_not_there_are_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert vehicles.main(["--data", str(tmp_path), "--out", str(tmp_path)]) == 2
    assert str(tmp_path) in capsys.readouterr().err
