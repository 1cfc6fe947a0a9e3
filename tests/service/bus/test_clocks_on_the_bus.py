"""Wrong clocks on a real bus: learning goes on, or health says why it cannot, and a clean restart hears again."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
import zenoh

from service import wire
from tests.service.commands.test_processes import (
    KEYS,
    client_after,
    endpoint,
    following,
    next_model,
    serving,
    taken_until,
)
from tests.service.conftest import PATIENCE, teach

__all__ = ["endpoint"]


@pytest.mark.slow
def test_a_clean_restart_hears_again(endpoint: str, tmp_path: Path) -> None:
    """The clock of the yaw rate was believed to be far ahead, and was saved like this."""
    with client_after(endpoint, tmp_path) as (process, session, alive):
        models = following(session)
        teach(session, KEYS, 9, 0, 35)
        next_model(models)
        payload = wire.measurement(tuple(1e9 + 0.02 * k for k in range(50)), (0.1,) * 50)
        session.put(KEYS.rate, payload, congestion_control=zenoh.CongestionControl.BLOCK)
        taken_until(session, 34.9)
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) == 0
        assert "DELETE" in alive.get(timeout=PATIENCE)
        with serving(endpoint, tmp_path):
            assert "PUT" in alive.get(timeout=PATIENCE)
            teach(session, KEYS, 9, 35, 80)
            model = next_model(models)
            if model.revision == 1:
                model = next_model(models)
            assert model.revision == 2
            assert 35.0 < model.t < 80.0
