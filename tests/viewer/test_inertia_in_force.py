"""One inertia is in force, and every place shows that one: page, screen and export of a learner."""

from __future__ import annotations

import pytest

from service import wire
from service.commands.status import text
from service.export.learned import of_snapshot
from service.export.table import as_csv
from viewer.page.learner import curve


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
    snapshot = wire.ModelSnapshot(
        boot="b", revision=3, iteration=3, t=812.0, kernel=wire.Kernel(gamma=0.25), epsilon=0.01, C=60.0,
        support=wire.Support(rate=(-1.0, 0.5, 1.0), damping=(-3.0, 1.0, 3.0), weight=(-2.0, 0.5, 2.0)),
        inertia=1.125, effects=effects, noise=0.2, trained_range=(-1.0, 1.0),
    )  # fmt: skip
    assert snapshot.inertia_in_force == curve(snapshot)["inertia"] == inertia
    health = wire.Health(level="OK", boot="b")
    assert f"I = {inertia:g} kg m²" in text("leng/yaw", health, snapshot)
    assert f"inertia,{inertia}" in as_csv(of_snapshot(snapshot, "learner"))
