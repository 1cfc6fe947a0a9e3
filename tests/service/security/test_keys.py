"""`incsvr keys` and what `incsvr config check` says of its files, when they are good and when they are not."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID

from service.cli.command_line import main

Check = Callable[..., str]


@pytest.fixture
def folder() -> Iterator[Path]:
    """A folder that other users can enter, unlike pytest's own."""
    with TemporaryDirectory() as name:
        path = Path(name).resolve()
        path.chmod(0o755)
        yield path


@pytest.fixture
def check(folder: Path, capsys: pytest.CaptureFixture[str]) -> Check:
    """What `config check` says of a configuration with the folder's learner.json5; the first word is the status."""

    def said(*words: str, prefix: str = "leng/yaw") -> str:
        path = folder / "config.yaml"
        path.write_text(f"bus: {{zenoh_file: {folder}/tls/learner.json5}}\nstate: null\nprefix: {prefix}\n")
        capsys.readouterr()
        status = main(["config", "check", str(path), *words])
        out, err = capsys.readouterr()
        assert (out + err).count("\n") == 1
        return f"{status} {out}{err}"

    return said


def keys(folder: Path, *words: str) -> int:
    return main(["keys", str(folder / "tls"), *words])


def test_certificates_are_for_their_role_alone(folder: Path) -> None:
    assert keys(folder, "--listen", "tls/192.168.2.2:7447", "--name", "rov.local") == 0
    for role in ("learner", "vehicle", "viewer", "operator"):
        certificate = x509.load_pem_x509_certificate((folder / "tls" / f"{role}.pem").read_bytes())
        assert certificate.subject.rfc4514_string() == f"CN={role}"
        key = certificate.public_key()
        assert isinstance(key, ec.EllipticCurvePublicKey)
        assert isinstance(key.curve, ec.SECP256R1)
        purposes = certificate.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value
        expected = ExtendedKeyUsageOID.SERVER_AUTH if role == "learner" else ExtendedKeyUsageOID.CLIENT_AUTH
        assert list(purposes) == [expected]
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
        addresses = {str(address) for address in names.get_values_for_type(x509.IPAddress)}
        assert addresses == ({"192.168.2.2", "127.0.0.1", "::1"} if role == "learner" else set())
        assert stat.S_IMODE((folder / "tls" / f"{role}.key").stat().st_mode) == 0o600
    assert stat.S_IMODE((folder / "tls" / "ca.key").stat().st_mode) == 0o600


def test_a_second_run_replaces_nothing_unless_asked(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def contents() -> dict[str, bytes]:
        return {path.name: path.read_bytes() for path in (folder / "tls").iterdir()}

    assert keys(folder, "--role", "learner", "--role", "vehicle") == 0
    first = contents()
    assert keys(folder) == 2
    assert "already contains an authority" in capsys.readouterr().err
    assert keys(folder, "--role", "vehicle") == 2
    assert "already contains a key of the vehicle" in capsys.readouterr().err
    assert contents() == first
    assert keys(folder, "--role", "viewer") == 0
    added = contents()
    assert first.items() <= added.items()
    authority = x509.load_pem_x509_certificate(added["ca.pem"])
    x509.load_pem_x509_certificate(added["viewer.pem"]).verify_directly_issued_by(authority)
    assert keys(folder, "--replace") == 0
    assert contents()["ca.pem"] != first["ca.pem"]
    (folder / "tls" / "ca.key").unlink()
    assert keys(folder, "--role", "viewer", "--replace") == 2
    assert "bring both files back" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--prefix", "a b"], "a prefix is names with slashes between them"),
        (["--listen", "tcp/127.0.0.1:7447"], "name a TLS endpoint"),
        (["--owner", "no_such_user"], "there is no such user"),
    ],
)
def test_what_cannot_be_is_one_sentence(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], sentence: str
) -> None:
    assert keys(folder, *words) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1
    assert not (folder / "tls").exists()


def test_good_files_are_said_to_be_good(folder: Path, check: Check) -> None:
    keys(folder, "--prefix", "rov7/yaw")
    assert check(prefix="rov7/yaw").startswith("0 ")
    assert "allows nobody to publish leng/yaw/rate" in check()


def test_a_file_that_the_units_user_cannot_read_is_named(folder: Path, check: Check) -> None:
    """Root reads everything, so it must look as the user that the unit runs as."""
    keys(folder)
    key = folder / "tls" / "learner.key"
    key.chmod(0o000)
    root = os.geteuid() == 0
    said = check("--user", "nobody") if root else check()
    assert said.startswith("2 ")
    assert f"{key} cannot be read by {'nobody' if root else ''}" in said
    if root:
        assert keys(folder, "--role", "learner", "--owner", "nobody", "--replace") == 0
        assert check("--user", "nobody").startswith("0 ")
        assert keys(folder, "--role", "learner", "--replace") == 0  # for another prefix, say: it stays nobody's
        assert check("--user", "nobody").startswith("0 ")
        (folder / "tls").chmod(0o700)
        assert f"the folder {folder / 'tls'} is closed" in check("--user", "nobody")
    else:
        assert "only root can check" in check("--user", "root")


def test_a_file_that_is_missing_is_named(folder: Path, check: Check) -> None:
    keys(folder)
    tls = folder / "tls"
    (tls / "ca.pem").unlink()
    assert f"root_ca_certificate: {tls / 'ca.pem'}: there is no such file" in check()
