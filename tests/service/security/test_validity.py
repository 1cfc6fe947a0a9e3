"""Certificates that end soon, have ended or are not valid yet, and clocks that are wrong: each named, with its cure."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from datetime import timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding

from incsvr.errors import BadInput
from service import wire
from service.bus.bus_check import check_bus
from service.bus.session import (
    BusRefusal,
    certificates,
    client_config_at,
    endpoints,
    free_endpoint,
    from_file,
    open_session,
)
from service.cli.command_line import main
from service.config.sections import Bus
from service.host.host import Host
from service.host.worker_threads import WorkerThreads
from service.security.certificate_validity import dates
from tests.service.conftest import configured
from tests.service.security.secured import redated, until_settled

DAY = timedelta(days=1)


@pytest.fixture
def tls(tmp_path: Path) -> Path:
    """Keys of every role for a free port."""
    folder = tmp_path / "tls"
    assert main(["keys", str(folder), "--listen", free_endpoint().replace("tcp/", "tls/")]) == 0
    return folder


def test_a_certificate_that_ends_soon_is_on_health_in_the_check_and_said_by_the_client(
    tls: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    redated(tls, "learner", -DAY, 23.5 * DAY)
    redated(tls, "viewer", -DAY, 3.5 * DAY)
    soon = f"the certificate {tls}/learner.pem ends on"
    assert f"{soon} " in check_bus(Bus(zenoh_file=tls / "learner.json5"), ["leng/yaw"])
    config = configured(bus={"zenoh_file": str(tls / "learner.json5")})
    with ExitStack() as stack:
        session = stack.enter_context(open_session(from_file(tls / "learner.json5")))
        assert soon in caplog.text
        stack.enter_context(WorkerThreads([Host(session, config)]))
        with open_session(from_file(tls / "viewer.json5")) as client:
            until_settled(client, wire.Keys("leng/yaw"))
        assert main(["status", "--set", f"bus.zenoh_file={tls / 'viewer.json5'}"]) == 1
        assert f"the certificate {tls}/viewer.pem ends on" in caplog.text
        # The screen folds a long path wherever its width ends, so that only the letters count.
        shown = "".join(capsys.readouterr().out.split())
        assert "learner.pemendson" in shown
        assert "in23days" in shown


@pytest.mark.parametrize(
    ("role", "begins", "ends", "sentence"),
    [
        ("viewer", -9 * DAY, -DAY, "the certificate {tls}/viewer.pem ended on"),
        ("viewer", DAY, 9 * DAY, "the certificate {tls}/viewer.pem is valid from"),
    ],
)
def test_a_client_that_is_not_let_in_says_whose_certificate_it_is(
    tls: Path, capsys: pytest.CaptureFixture[str], role: str, begins: timedelta, ends: timedelta, sentence: str
) -> None:
    redated(tls, role, begins, ends)
    with open_session(from_file(tls / "learner.json5")):
        for command in (["status"], ["query", "0.1"], ["status", "--follow"]):
            assert main([*command, "--wait", "60", "--set", f"bus.zenoh_file={tls / 'viewer.json5'}"]) == 2
            said = capsys.readouterr().err
            assert sentence.format(tls=tls, endpoint=endpoint(tls)) in said
            assert said.count("\n") == 1


def test_an_expired_certificate_of_ones_own_is_refused_by_the_check_and_said_at_the_start(
    tls: Path, caplog: pytest.LogCaptureFixture
) -> None:
    redated(tls, "learner", -9 * DAY, -DAY)
    with pytest.raises(BadInput, match=r"learner\.pem ended on .*, and nobody accepts it any more: `incsvr keys"):
        check_bus(Bus(zenoh_file=tls / "learner.json5"), ["leng/yaw"])
    with open_session(from_file(tls / "learner.json5")):
        assert "learner.pem ended on" in caplog.text


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


def test_where_nobody_listens_or_nothing_is_secured_no_certificate_is_blamed(tls: Path) -> None:
    with pytest.raises(BadInput, match="Unable to connect") as failed:
        open_session(from_file(tls / "viewer.json5"))
    assert not isinstance(failed.value, BusRefusal)
    assert certificates(client_config_at("tcp/127.0.0.1:1")) == ()


def endpoint(tls: Path) -> str:
    """Where the learner of these keys listens."""
    (found,) = endpoints(from_file(tls / "learner.json5"), "listen")
    return found


@pytest.mark.parametrize("years", [1, 40])
def test_the_dates_are_those_of_the_certificate(tls: Path, years: int) -> None:
    """From 2050 on they are written in another form."""
    redated(tls, "viewer", -DAY, 365 * years * DAY)
    found = x509.load_pem_x509_certificate((tls / "viewer.pem").read_bytes())
    assert dates(found.public_bytes(Encoding.DER)) == (found.not_valid_before_utc, found.not_valid_after_utc)
