"""What docs/bus.md says is so: its clients run as they stand, and its payloads are those of the learner."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from incsvr.numerics.plain import to_plain
from service import wire
from service.inputs.forms.own import parse
from service.learner.questions import MAX_RATES
from tests.service.commands.test_processes import KEYS, client_after, endpoint, following, next_model
from tests.service.conftest import teach

__all__ = ["endpoint"]

DOCS = Path(__file__).resolve().parents[3] / "docs"
PAGE = (DOCS / "bus.md").read_text(encoding="utf-8")
CLIENT = DOCS / "client.py"
PAYLOADS = re.findall(r"```json\n(.*?)```", PAGE, re.DOTALL)


def test_the_client_of_twenty_lines_runs(endpoint: str, tmp_path: Path) -> None:
    lines = CLIENT.read_text(encoding="utf-8").splitlines()
    assert sum(bool(line.strip()) and not line.startswith(("import", "from", '"""')) for line in lines) <= 20
    with client_after(endpoint, tmp_path / "state") as (_, session, _alive):
        models = following(session)
        teach(session, KEYS, 9, 0, 35)
        model = next_model(models)
        ran = subprocess.run([sys.executable, CLIENT, endpoint], capture_output=True, text=True, check=True)
    health, damping = ran.stdout.splitlines()
    assert "'streams': {'yaw_rate': {'received': " in health
    assert f"'revision': {model.revision}" in damping
    assert "'damping': [" in damping


def test_the_client_that_joins_late_has_the_latest_model_and_then_the_next(endpoint: str, tmp_path: Path) -> None:
    command = [sys.executable, str(DOCS / "follow.py"), endpoint]
    with client_after(endpoint, tmp_path / "state") as (_, session, _alive):
        models = following(session)
        teach(session, KEYS, 9, 0, 35)
        latest = next_model(models)
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as late:
            try:
                assert late.stdout is not None
                assert late.stdout.readline() == _line(latest)
                teach(session, KEYS, 9, 35, 70)
                assert late.stdout.readline() == _line(next_model(models))
            finally:
                late.kill()


def _line(model: wire.ModelSnapshot) -> str:
    """What the client prints of a model."""
    damping = float(model.model.predict(np.array([0.1])).damping[0])
    return f"revision {model.revision}: {damping:.1f} N m at 0.1 rad/s\n"


def test_the_measurements_are_taken() -> None:
    for line in PAYLOADS[0].splitlines():
        t, value, _ = parse(line.encode())
        assert len(t) == len(value)


@pytest.mark.parametrize(
    ("position", "form"),
    [
        (1, wire.ModelSnapshot),
        (2, wire.DampingReply),
        (3, wire.FeedforwardReply),
        (4, wire.ForecastReply),
        (5, wire.ThrustEvent),
        (6, wire.Health),
        (7, wire.EffectsLedger),
        (8, wire.ErrorReply),
    ],
)
def test_the_payloads_are_those_of_the_learner(position: int, form: type[wire.Form]) -> None:
    payload = PAYLOADS[position]
    assert set(json.loads(payload)) == set(to_plain(wire.decode(form, payload.encode())))


def test_the_client_with_a_plan_is_answered(endpoint: str, tmp_path: Path) -> None:
    with client_after(endpoint, tmp_path / "state") as (_, session, _alive):
        models = following(session)
        teach(session, KEYS, 9, 0, 35)
        next_model(models)
        ran = subprocess.run([sys.executable, DOCS / "plan.py", endpoint], capture_output=True, text=True, check=True)
    torque = json.loads(ran.stdout[: ran.stdout.index("]") + 1])
    assert len(torque) == 4
    assert torque[1] > torque[3]


def test_every_key_and_limit_stands_there() -> None:
    for key in (
        KEYS.rate,
        KEYS.torque,
        KEYS.model,
        KEYS.iteration,
        KEYS.damping,
        KEYS.event,
        KEYS.feedforward,
        KEYS.health,
        KEYS.effects,
        KEYS.coefficients,
        KEYS.alive,
    ):
        assert f"`{key}`" in PAGE
    assert f"at most {MAX_RATES} rates" in PAGE
