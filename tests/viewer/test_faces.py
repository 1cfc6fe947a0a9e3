"""`sigma`, `doubt` and `noise`: at one rate every face of a model gives the same figures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from service import wire
from service.commands.python_api import fit
from service.commands.query import table
from service.export.learned import of_file, of_snapshot
from service.export.table import as_json
from service.learner.damping_query import DampingQuery
from service.learner.published import ServedModel, damping_reply, snapshot
from service.recordings.recording_csv import write
from simulator import leng
from viewer.page.learner import curve


def test_the_same_rate_asked_everywhere_gives_the_same_figures(tmp_path: Path) -> None:
    write(tmp_path / "dive.csv", leng.recording("T1", 0))
    fitted = fit(tmp_path / "dive.csv", (), {"inertia": 350.0})
    told, model = fitted.to_dict(), fitted.pictures.model
    rate = told["curve"]["rate"]
    said = fitted.predict(rate)
    expected = [rate, *(getattr(said, name).tolist() for name in ("damping", "sigma", "doubt"))]
    np.testing.assert_allclose(said.sigma, np.hypot(said.doubt, said.noise))
    assert (said.doubt < said.sigma).all()

    served = wire.decode(wire.ModelSnapshot, wire.encode(snapshot(ServedModel(model, 1, 1, 0.0), "boot", 350.0)))
    reply = damping_reply(model, DampingQuery(tuple(rate)), 1, 1)
    answer = json.loads(wire.encode(reply))
    (tmp_path / "fit.json").write_text(json.dumps(told), encoding="utf-8")
    exported = json.loads(as_json(of_snapshot(served, "learner")))
    of_log = json.loads(as_json(of_file(tmp_path / "fit.json")))
    for face in (told["curve"], answer, exported["curve"], of_log["curve"]):
        assert [face[name] for name in ("rate", "damping", "sigma", "doubt")] == expected
    earlier = json.loads(wire.encode(served))
    del earlier["noise"]
    assert wire.decode(wire.ModelSnapshot, json.dumps(earlier).encode()).noise == served.noise
    page = curve(served)
    drawn = model.predict(page["rate"])
    assert [page["sigma"], page["doubt"]] == [drawn.sigma.tolist(), drawn.doubt.tolist()]
    assert {served.noise, served.sigma, page["noise"], exported["noise"]} == {model.sigma}
    assert table(reply).splitlines()[1].split()[1:4] == [f"{each[0]:.2f}" for each in expected[1:]]
