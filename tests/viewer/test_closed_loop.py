"""The loop closed on a measured vehicle: fit, trace, its effects on the bus, and the same errors everywhere."""

from __future__ import annotations

import json
import queue
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from service.cli.command_line import main
from service.config.sources import read
from service.config.traced_effects import configured_effects
from service.recordings.validation import read_validation
from service.wire import EffectsLedger, IterationReport, ModelSnapshot, decode
from tests.viewer.conftest import KEYS, PATIENCE, House
from tests.viewer.readback import every

INERTIA = "1.01"
"""As `incsvr trace --inertia estimate` estimates it of the two runs [kg m²]."""


def replayed(house: House, config: Path, run: Path, rrd: Path) -> tuple[float, EffectsLedger, list[IterationReport]]:
    """The error of the model that a learner serves [N m], its effects, and its reports while the run is replayed."""
    learner = house.start(["serve", "--config", str(config), "--set", f"bus.listen={house.endpoint}"])
    learner.wait_for("ready")
    viewer = house.view("--headless", "--save", str(rrd))
    viewer.wait_for("the learner is here")
    session, reports = house.client(), queue.Queue[IterationReport]()
    session.declare_subscriber(KEYS.iteration, lambda one: reports.put(decode(IterationReport, one.payload.to_bytes())))
    said = [next(iter(session.get(key, timeout=PATIENCE))).ok for key in (KEYS.model, KEYS.effects)]
    model, ledger = (None if each is None else each.payload.to_bytes() for each in said)
    assert model is not None
    assert ledger is not None
    configured = read(config)
    samples = read_validation(run, configured, configured_effects(configured))
    learned = decode(ModelSnapshot, model).model.predict(samples.yaw_rate).damping
    assert house.start(["replay", str(run), "--connect", house.endpoint, "--speed", "50"]).wait() == 0
    viewer.wait_for("iteration 10 ")  # six of the fit, four of the run
    assert viewer.end() == 0
    assert learner.end() == 0
    return (
        float(np.mean(np.abs(samples.damping - learned))),
        decode(EffectsLedger, ledger),
        [reports.get() for _ in range(4)],
    )


@pytest.mark.slow
def test_the_errors_are_the_same_on_the_bus_in_the_report_and_in_the_recording(
    house: House, measured: Path, tmp_path: Path
) -> None:
    one, other, unseen = (measured / "bluerov" / f"run_{number}.csv" for number in ("04", "05", "03"))
    runs = [str(one), str(other), "--validate", str(unseen), "--inertia", INERTIA]
    trace = tmp_path / "trace.json"
    assert main(["trace", *runs, "--json", str(trace)]) == 0
    found = json.loads(trace.read_text(encoding="utf-8"))
    names = [each["effect"] for each in found["effects"]]
    assert "torque_lag" in names
    errors: dict[str, dict[str, Any]] = {}
    for name, more in (("before", []), ("after", ["--effects", str(trace)])):
        path, config = tmp_path / name, str(tmp_path / f"{name}.yaml")
        assert main(["fit", *runs, *more, "--write", config, "--state", str(path)]) == 0
        state = ["--config", config, "--write", config, "--force"]
        assert main(["fit", *runs[:-2], *state, "--report", f"{path}.html", "--json", f"{path}.json"]) == 0
        errors[name] = json.loads((tmp_path / f"{name}.json").read_text(encoding="utf-8"))["validation"]
        page = (tmp_path / f"{name}.html").read_text(encoding="utf-8")
        assert f"On unseen recordings the free run errs by {errors[name]['free_run_rmse']:.3g} rad/s" in page
    assert errors["after"]["free_run_rmse"] < 0.95 * errors["before"]["free_run_rmse"]

    rrd = tmp_path / "run.rrd"
    error, ledger, reports = replayed(house, tmp_path / "after.yaml", unseen, rrd)
    assert [each["effect"] for each in ledger.effects] == names
    assert error == pytest.approx(errors["after"]["mae"], rel=1e-9)
    told = [np.array(each.batch.damping) - np.array(each.batch.predicted) for each in reports]
    # The recording begins with the batches of the fit; the clock of the run begins anew.
    measured_torque, predicted, lag = (
        np.array(every(rrd, "Scalars:scalars", f"/effects/{name}"))[-sum(map(len, told)) :]
        for name in ("torque/measured", "torque/predicted", "parts/torque_lag")
    )
    np.testing.assert_allclose(measured_torque - predicted, np.concatenate(told), atol=1e-9)
    assert np.mean(np.abs(told[0])) == pytest.approx(reports[0].progressive_mae, rel=1e-6)
    np.testing.assert_allclose(lag, np.concatenate([each.batch.parts["torque_lag"] for each in reports]))
