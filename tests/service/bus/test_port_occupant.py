"""A port that is in use: who is there, and the flags that help."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from service.bus.session import BusRefusal, free_endpoint, from_file, listener_config_at, open_session
from service.cli.command_line import main
from service.wire import Keys
from tests.service.security.test_validity import tls

__all__ = ["tls"]


def refused(endpoint: str) -> str:
    with pytest.raises(BusRefusal) as failed:
        open_session(listener_config_at(endpoint))
    return str(failed.value)


def test_a_learner_is_named_with_the_command_that_shows_it(capsys: pytest.CaptureFixture[str]) -> None:
    endpoint = free_endpoint()
    with open_session(listener_config_at(endpoint)) as there:
        assert f"{endpoint} is in use by a Zenoh router or program without a learner" in refused(endpoint)
        assert f"its client with --connect {endpoint}, or listen at another port with --listen" in refused(endpoint)
        tokens = [there.liveliness().declare_token(Keys(prefix).alive) for prefix in ("rov/yaw", "auv/yaw")]
        assert main(["serve", "--listen", endpoint, "--set", "state=null"]) == 2
        said = capsys.readouterr().err
        assert f"{endpoint} is in use by the learner of auv/yaw, rov/yaw; `incsvr status --connect {endpoint}" in said
        assert "--listen" in said
        assert said.count("\n") == 1
        del tokens


def test_another_program_is_no_bus() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        assert "in use by a program that does not answer as a bus" in refused(
            f"tcp/127.0.0.1:{server.getsockname()[1]}"
        )


def test_a_secured_port_is_said_to_be_a_learners_or_a_routers(tls: Path) -> None:
    config = from_file(tls / "learner.json5")
    with (
        open_session(config),
        pytest.raises(BusRefusal, match=r"in use, by another learner or a router; `incsvr status`"),
    ):
        open_session(config)
