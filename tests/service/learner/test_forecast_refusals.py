"""What a forecast refuses: a plan beyond the plausible, and a start without measurements, in the axis's own words."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.errors import BadInput
from service import wire
from service.learner.estimates import forecast_reply
from service.learner.node import LearnerNode
from tests.service.conftest import configured
from tests.service.learner.test_stand_in import taught


def test_a_learner_of_surge_names_its_velocity_and_force() -> None:
    """Where a forecast has nothing to begin with, and where nothing came lately."""
    node = LearnerNode(configured(vehicle__axis="surge"), boot="")
    model, once = taught().served.model, np.zeros(1)
    with pytest.raises(BadInput, match="no surge velocity or no force has arrived"):
        node.stand_in.since_measured(model, 1.0, True)
    node.push("yaw_rate", once, once)
    node.push("torque", once + 250.0, once)
    with pytest.raises(BadInput, match="the last valid surge velocity is older than 300 s, or no force came with it"):
        node.stand_in.since_measured(model, 1.0, True)


@pytest.mark.parametrize("torque", [501.0, -1e300, 1e308])
def test_a_torque_beyond_the_plausible_is_refused_with_what_is_possible(torque: float) -> None:
    node = taught()
    with pytest.raises(BadInput, match=r"within the plausible ±500 N m \(vehicle.torque_limit\)") as refused:
        forecast_reply(node, wire.ForecastQuery(t=(0.0, 5.0), torque=(20.0, torque)))
    for steps in ({"t": (0.0, 5e-324)}, {"t": (0.0, 5.0), "at": (1.0, 1.0 + 3e-16)}):
        with pytest.raises(BadInput, match="less than a nanosecond apart"):
            forecast_reply(node, wire.ForecastQuery.model_validate({"torque": (20.0, 20.0), **steps}))
    assert str(refused.value).startswith(f"a torque of {torque:g} N m is planned")
    assert np.abs(forecast_reply(node, wire.ForecastQuery(t=(0.0, 5.0), torque=(20.0, 500.0))).rate).max() < 10.0
