"""What `identify` refuses to write: a velocity that stood still, a model that runs away."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.terms import LINEAR, Term
from incsvr.vehicle import Parameter, Vehicle
from service.cli.command_line import main
from service.fitting.identify import refuse_runaway
from service.recordings.recording import from_table
from service.recordings.recording_csv import write
from simulator import leng


@pytest.mark.slow
def test_a_pegged_sensor_gives_no_vehicle_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = leng.recording("T1", 0)
    pegged = {**run.columns, "yaw_rate": np.clip(run.columns["yaw_rate"], -0.1, 0.1)}
    write(tmp_path / "dive.csv", from_table("dive", run.time, pegged))
    written = tmp_path / "vehicle.yaml"
    for words in (["identify", "--write", str(written)], ["trace", "--inertia", "350"], ["fit", "--inertia", "350"]):
        assert main([words[0], str(tmp_path / "dive.csv"), *words[1:]]) == 2
        said = capsys.readouterr().err
        assert "the yaw rate is constant at -0.1 rad/s" in said
        assert "stuck, or clipped at the end of its range" in said
    assert not written.exists()


@pytest.mark.parametrize(("drag", "runs_away"), [(100.0, False), (-100.0, True)])
def test_a_model_that_runs_away_is_refused(drag: float, runs_away: bool) -> None:
    time: Array = np.linspace(0.0, 60.0, 601, dtype=np.float64)
    wave: Array = np.asarray(np.sin(0.3 * time))
    runs = [{"yaw_rate": (time, 0.1 * wave), "torque": (time, 20.0 * wave)}]
    known = Parameter(350.0, 350.0, 350.0)
    terms = {Term("yaw", LINEAR): Parameter(drag, drag, drag)}
    fastest = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.1])
    vehicle = Vehicle("auv", ("yaw",), ("yaw",), {("yaw", "yaw"): known}, terms, {}, fastest)
    if not runs_away:
        refuse_runaway(runs, vehicle)
        return
    with pytest.raises(BadInput, match="passes 5 times the fastest recorded velocity of yaw; nothing is written"):
        refuse_runaway(runs, vehicle)
