"""The recording holds the learner's numbers: every set of every iteration, the curve, the figures."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from service.wire import SETS, EffectsLedger, Health, Measurement, Points, Validation
from tests.viewer.conftest import Run
from tests.viewer.readback import every, points, rows, series, shown, verify
from viewer import texts, window
from viewer.compare import Choice
from viewer.frame import Frame, positions
from viewer.pages import blueprint
from viewer.recorder import Recorder
from viewer.recording import Recording, efforts
from viewer.thrust import SHOWN


@contextmanager
def recording(path: Path, choice: Choice = Choice()) -> Iterator[Recording]:  # noqa: B008
    """A recording that is written by the end of the `with`."""
    recorder = Recorder(blueprint(), path=path)
    yield Recording(recorder, choice, rate=0.25)
    recorder.close()


def record(run: Run, path: Path, choice: Choice) -> None:
    with recording(path, choice) as pages:
        play(run, pages)


def play(run: Run, pages: Recording) -> None:
    """The run as it comes in from the bus."""
    newest = 0.0
    for report, snapshot in run.iterations:
        now = time.time()
        for name, (t, value) in run.part(newest, report.t).items():
            pages.measured(name, Measurement(t=tuple(t.tolist()), value=tuple(value.tolist())), now)
        depth = np.arange(newest, report.t - 10.0, 0.5)  # a pause of ten seconds before each iteration
        pages.measured("depth", Measurement(t=tuple(depth.tolist()), value=tuple((0.1 * depth).tolist())), now)
        newest = report.t
        pages.iteration(Frame(report, snapshot, now))
        counters = {"rejected": 3, "rejected:late": 2, "rejected:duplicate": 1}
        pages.health(Health(level="OK", boot="a test", counters=counters, t=report.t), now)
        assert pages.flush()


@pytest.fixture(scope="module")
def recorded(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recorded") / "run.rrd"
    record(run, path, Choice())
    return path


def test_every_set_of_every_iteration_is_there_with_the_learners_numbers(run: Run, recorded: Path) -> None:
    logged = rows(recorded, "Points2D:positions")
    for report, _ in run.iterations:
        for name in SETS:
            expected = positions(getattr(report, name)).astype(np.float32)
            found = points(shown(logged[f"/learning/{name}"], report.iteration))
            assert np.array_equal(found, expected), f"{name} of iteration {report.iteration}"


def test_the_curve_is_the_served_model(run: Run, recorded: Path) -> None:
    logged = rows(recorded, "LineStrips2D:strips")
    for report, snapshot in run.iterations:
        model = snapshot.model
        curve = np.concatenate([points(strip) for strip in shown(logged["/learning/function"], report.iteration)])
        assert curve[[0, -1], 0] == pytest.approx(snapshot.model.trained_range, abs=1e-6)
        assert curve[:, 1] == pytest.approx(model.predict(curve[:, 0]).damping, abs=1e-3)
        tubes = [points(strip)[:, 1] for strip in shown(logged["/learning/tube"], report.iteration)]
        for below, above in zip(tubes[::2], tubes[1::2], strict=True):
            assert above - below == pytest.approx(2.0 * snapshot.model.epsilon, abs=1e-4)
        below, above, _ = (points(strip) for strip in shown(logged["/learning/uncertainty"], report.iteration))
        doubt = 1.96 * model.predict(below[:, 0]).sigma
        # Where both edges lie on the axes; beyond, they are cut.
        whole = (above[:, 1] < above[:, 1].max() - 1e-3) & (below[:, 1] > below[:, 1].min() + 1e-3)
        assert whole.sum() > 50
        assert (above - below)[whole, 1] == pytest.approx(2.0 * doubt[whole], abs=1e-3)


def test_what_is_dashed_is_extrapolated(run: Run, recorded: Path) -> None:
    logged = rows(recorded, "LineStrips2D:strips")
    for report, snapshot in run.iterations:
        model = snapshot.model
        for strip in shown(logged["/learning/extrapolation"], report.iteration):
            assert model.predict(points(strip)[1:-1, 0]).extrapolated.all()


def test_the_errors_are_there(run: Run, recorded: Path) -> None:
    logged = rows(recorded, "Scalars:scalars", "/error")["/error/progressive"]
    expected = {report.iteration: [report.progressive_mae] for report, _ in run.iterations[1:]}
    assert logged == expected


def test_the_error_of_the_untrained_model_is_in_the_name_of_the_curve(run: Run, tmp_path: Path) -> None:
    report, snapshot = run.iterations[0]
    check = Validation(name="V1", mae=5.0, rmse=6.0, samples=100, untrained=48.0)
    path = tmp_path / "run.rrd"
    first = replace(report, validation=(check,))
    with recording(path) as pages:
        pages.iteration(Frame(first, snapshot, None))
    assert rows(path, "Scalars:scalars", "/error") == {"/error/V1": {1: [5.0]}}
    assert every(path, "SeriesLines:names", "/error/V1") == ["Validation V1; untrained: 48 N m"]


def test_every_frame_has_its_table_axes_and_comparison(run: Run, recorded: Path) -> None:
    tables = rows(recorded, "TextDocument:text")
    for report, _ in run.iterations:
        (text,) = shown(tables["/learning/table"], report.iteration)
        assert f"Iteration {report.iteration} " in text
        (counts,) = shown(tables["/learning/samples"], report.iteration)
        assert f"| Support vectors | {len(report.support)} |" in counts
        (text,) = shown(tables["/learning/compared"], report.iteration)
        assert f"Iteration 1 and {report.iteration}" in text
    for name in ("axes", "compare_axes"):
        assert min(rows(recorded, "EncodedImage:blob")[f"/learning/{name}"]) == run.iterations[0][0].iteration


def test_a_further_channel_is_recorded_and_its_line_ends_at_its_pauses(run: Run, recorded: Path) -> None:
    depth = np.array(series(recorded, "/signals/channel")["/signals/channel/depth"])
    came = np.concatenate(
        [
            np.arange(before, report.t - 10.0, 0.5)
            for before, (report, _) in zip([0.0, *(each.t for each, _ in run.iterations)], run.iterations, strict=False)
        ]
    )
    assert depth[~np.isnan(depth)] == pytest.approx(0.1 * came)
    assert np.isnan(depth).sum() == len(run.iterations) - 1


def test_two_chosen_revisions_stand_still(run: Run, tmp_path: Path) -> None:
    record(run, tmp_path / "chosen.rrd", Choice(before=2, after=4))
    logged = rows(tmp_path / "chosen.rrd", "Points2D:positions")
    last = run.iterations[-1][0].iteration
    for name, chosen in (("before", 2), ("after", 4)):
        report, snapshot = run.iterations[chosen - 1]
        found = points(shown(logged[f"/learning/{name}/support"], last))
        assert np.array_equal(found, positions(report.support).astype(np.float32))
        assert snapshot.iteration == chosen
    for name, numbers in (("before", (1, 2)), ("after", (3, 4))):
        batches = [run.iterations[number - 1][0].batch for number in numbers]
        expected = np.concatenate([np.column_stack((batch.rate, batch.damping)) for batch in batches])
        found = points(shown(logged[f"/learning/{name}/samples"], last))
        assert np.array_equal(found, expected.astype(np.float32))


def test_a_recording_is_whole(recorded: Path) -> None:
    verify(recorded)
    assert window.is_whole(recorded)


def test_an_iteration_without_its_model_says_so(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "bare.rrd"
    with recording(path) as pages:
        pages.iteration(Frame(run.iterations[0][0], None, None))
    assert "curve is missing" in rows(path, "TextDocument:text")["/learning/table"][1][0]


def test_a_wild_sample_neither_moves_the_axes_nor_goes_unseen(run: Run, tmp_path: Path) -> None:
    report, snapshot = run.iterations[0]
    wild = Points(rate=(*report.outliers.rate, 0.1), damping=(*report.outliers.damping, 900.0))
    path = tmp_path / "wild.rrd"
    with recording(path) as pages:
        pages.iteration(Frame(replace(report, outliers=wild), snapshot, None))
        pages.iteration(Frame(*run.iterations[1], None))
    strips = rows(path, "LineStrips2D:strips")
    (arrow,) = shown(strips["/learning/off_scale"], 1)
    assert points(arrow)[1, 0] == pytest.approx(0.1)
    assert 50.0 < points(arrow)[1, 1] < 200.0
    assert shown(strips["/learning/off_scale"], 2) == []
    assert points(shown(rows(path, "Points2D:positions")["/learning/outliers"], 1))[-1].tolist() == [
        pytest.approx(0.1),
        900.0,
    ]


def test_the_torque_ledger_adds_up_and_the_effects_are_said(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "effects.rrd"
    with recording(path) as pages:
        # The learner says it when it begins, before there is an iteration.
        pages.effects(EffectsLedger(effects=({"effect": "torque_lag"},)), time.time())
        for report, snapshot in run.iterations[:2]:
            size = len(report.batch.time)
            parts = {"declared inertia": tuple(np.linspace(-9.0, 9.0, size).tolist()), "coupling:sway": (3.0,) * size}
            batch = replace(report.batch, parts=parts)
            pages.iteration(Frame(replace(report, batch=batch), snapshot, None))
    assert "## Torque lag" in shown(rows(path, "TextDocument:text", "/effects")["/effects/ledger"], 1)[0]
    found = efforts(batch)
    named = {f"effects/parts/{name}" for name in ("declared_inertia", "coupling_sway", "damping")}
    assert set(found) == named | {"effects/torque/measured", "effects/torque/predicted"}
    summed = np.sum([values for name, values in found.items() if "parts" in name], axis=0)
    assert found["effects/torque/predicted"] == pytest.approx(summed)
    logged = series(path, "/effects")
    for name, values in found.items():
        assert logged[f"/{name}"][-values.size :] == pytest.approx(values)


def test_an_effect_of_the_command_is_drawn_as_a_curve(run: Run, tmp_path: Path) -> None:
    """From the iteration after it was found to the one after it left, between the ends of its interval."""
    path, thrust = tmp_path / "thrust.rrd", [[-100.0, -70.0, -75.0, -66.0], [100.0, 70.0, 66.0, 75.0]]
    with recording(path) as pages:
        pages.iteration(Frame(*run.iterations[0], None))
        pages.effects(EffectsLedger(found=({"effect": "torque_saturation", "thrust_nm": thrust},)), time.time())
        pages.iteration(Frame(*run.iterations[1], None))
        pages.effects(EffectsLedger(), time.time())
        pages.iteration(Frame(*run.iterations[2], None))
    drawn = {name: rows(path, "LineStrips2D:strips", "/effects")[f"/{name}"] for name in SHOWN}
    assert [list(each) for each in drawn.values()] == [[2, 3]] * 3
    assert [each[3] for each in drawn.values()] == [[]] * 3
    without, made, doubt = (each[2] for each in drawn.values())
    assert points(made[0]).tolist() == [[-100.0, -70.0], [100.0, 70.0]]
    assert points(doubt[0]).tolist() == [[-100.0, -75.0], [100.0, 66.0]]
    assert all(command == thrust for dash in without for command, thrust in points(dash).tolist())


def test_what_is_found_stands_in_the_ledger_with_its_state_and_interval() -> None:
    sentence = "torque_lag: the torque lags; time constant 0.71 (0.66 to 0.76) s."
    found = {"effect": "torque_lag", "state": "suspected", "sentence": sentence, "p_value": 0.0}
    said = texts.ledger(EffectsLedger(mode="advise", found=(found,)))
    assert "## Torque lag (suspected)\nThe torque lags; time constant 0.71 (0.66 to 0.76) s.\n- p < 1e-300" in said
