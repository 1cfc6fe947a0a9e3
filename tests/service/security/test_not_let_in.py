"""Clients that are not let in: each is given what to compare."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from incsvr.errors import BadInput
from service.bus.session import BusRefusal, endpoints, free_endpoint, from_file, open_session
from service.cli.command_line import main


@pytest.fixture
def tls(tmp_path: Path) -> Path:
    """Keys of every role for a free port."""
    folder = tmp_path / "tls"
    assert main(["keys", str(folder), "--listen", free_endpoint().replace("tcp/", "tls/")]) == 0
    return folder


def other_authority(tls: Path) -> str:
    """The viewer has the keys of another vehicle."""
    other = tls.parent / "other"
    assert main(["keys", str(other), "--listen", endpoint(tls)]) == 0
    return str(other / "viewer.json5")


def no_certificate(tls: Path) -> str:
    """The viewer shows none."""
    path = tls / "bare.json5"
    text = (tls / "viewer.json5").read_text()
    path.write_text("\n".join(line for line in text.splitlines() if "connect_" not in line))
    return str(path)


@pytest.mark.parametrize(
    "client",
    [other_authority, no_certificate],
)
def test_whoever_is_not_let_in_is_told_to_compare_the_keys(
    tls: Path, client: Callable[[Path], str], capsys: pytest.CaptureFixture[str]
) -> None:
    with open_session(from_file(tls / "learner.json5")):
        assert main(["status", "--wait", "0.5", "--set", f"bus.zenoh_file={client(tls)}"]) != 0
    assert "if it runs, use the files that `incsvr keys` made with its own" in capsys.readouterr().err


def test_where_nobody_listens_no_certificate_is_blamed(tls: Path) -> None:
    with pytest.raises(BadInput, match="Unable to connect") as failed:
        open_session(from_file(tls / "viewer.json5"))
    assert not isinstance(failed.value, BusRefusal)


def endpoint(tls: Path) -> str:
    """Where the learner of these keys listens."""
    (found,) = endpoints(from_file(tls / "learner.json5"), "listen")
    return found
