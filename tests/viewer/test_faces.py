"""Every face of a model gives the same figures: `sigma`, `doubt` and `noise` at one rate, the inertia in force."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import incsvr
from incsvr.learning.coefficients import NORMAL_95_DEVIATIONS
from incsvr.learning.model import Model
from service import wire
from service.commands.query import table
from service.commands.status import text
from service.export.command import in_format
from service.export.learned import of_file, of_snapshot
from service.learner.published import damping_reply
from service.recordings.recording_csv import write
from simulator import leng
from viewer.page.learner import curve


def test_the_same_rate_asked_everywhere_gives_the_same_figures(tmp_path: Path) -> None:
    write(tmp_path / "dive.csv", leng.recording("T1", 0))
    fitted = incsvr.fit(tmp_path / "dive.csv", inertia=350.0)
    told, model = fitted.to_dict(), fitted.model
    rate = told["curve"]["rate"]
    said = fitted.predict(rate)
    expected = [rate, *(getattr(said, name).tolist() for name in ("damping", "sigma", "doubt"))]
    np.testing.assert_allclose(said.sigma, np.hypot(said.doubt, said.noise))
    assert (said.doubt < said.sigma).all()

    learned = wire.ModelSnapshot(boot="boot", revision=1, iteration=1, t=0.0, model=model, inertia=350.0)
    served = wire.decode(wire.ModelSnapshot, wire.encode(learned))
    reply = damping_reply(served, wire.DampingQuery(tuple(rate)))
    answer = json.loads(wire.encode(reply))
    (tmp_path / "fit.json").write_text(json.dumps(told), encoding="utf-8")
    exported = json.loads(in_format(of_snapshot(served, "learner"), "json")[0])
    of_log = json.loads(in_format(of_file(tmp_path / "fit.json"), "json")[0])
    for face in (told["curve"], answer, exported["curve"], of_log["curve"]):
        assert [face[name] for name in ("rate", "damping", "sigma", "doubt")] == expected
    earlier = json.loads(wire.encode(served))
    del earlier["noise"]
    assert wire.decode(wire.ModelSnapshot, json.dumps(earlier).encode()).noise == served.noise
    page = curve(served)
    drawn = model.predict(page["rate"])
    assert [page["sigma"], page["doubt"]] == [drawn.sigma.tolist(), drawn.doubt.tolist()]
    assert {served.noise, served.to_dict()["sigma"], page["noise"], exported["noise"]} == {model.sigma}
    printed = (said.damping[0], NORMAL_95_DEVIATIONS * said.doubt[0], NORMAL_95_DEVIATIONS * said.sigma[0])
    assert table(reply).splitlines()[1].split()[1:4] == [f"{each:.2f}" for each in printed]


@pytest.mark.parametrize(
    ("effects", "inertia"),
    [
        ((), 1.125),
        (({"effect": "torque_lag", "parameters": {"time_constant_s": 0.1}},), 1.125),
        (({"effect": "inertia", "parameters": {"inertia_kg_m2": 0.864}},), 0.864),
    ],
)
def test_page_screen_and_export_show_the_inertia_in_force(
    effects: tuple[dict[str, object], ...], inertia: float
) -> None:
    rate, damping, weight = np.array([[-1.0, 0.5, 1.0], [-3.0, 1.0, 3.0], [-2.0, 0.5, 2.0]])
    model = Model(0.25, 60.0, 0.01, rate, damping, weight, np.ones(3), sigma=0.2, certified_error=0.0)
    snapshot = wire.ModelSnapshot(
        boot="b", revision=3, iteration=3, t=812.0, model=model, inertia=1.125, effects=effects
    )
    assert snapshot.inertia_in_force == curve(snapshot)["inertia"] == inertia
    health = wire.Health(level="OK", boot="b")
    assert f"I = {inertia:g} kg m²" in text("leng/yaw", health, snapshot)
    assert f"inertia,{inertia}" in in_format(of_snapshot(snapshot, "learner"), "csv")[0]
