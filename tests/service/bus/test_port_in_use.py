"""A port that is in use: the commands that show by whom, and the flags that help."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from service.bus.session import BusRefusal, from_file, open_session
from service.cli.command_line import main
from tests.service.security.test_validity import tls

__all__ = ["tls"]


def test_a_port_in_use_names_the_commands_and_flags_that_help(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        endpoint = f"tcp/127.0.0.1:{server.getsockname()[1]}"
        assert main(["serve", "--listen", endpoint, "--set", "state=null"]) == 2
    said = capsys.readouterr().err
    assert f"{endpoint} is in use, by another learner, a router or another program (`incsvr status` shows" in said
    assert f"with --listen, or be its client with --connect {endpoint}" in said
    assert said.count("\n") == 1


def test_a_secured_port_in_use_asks_for_keys_of_another(tls: Path) -> None:
    config = from_file(tls / "learner.json5")
    with (
        open_session(config),
        pytest.raises(BusRefusal, match=r"make keys for another port \(`incsvr keys --listen`\)"),
    ):
        open_session(config)
