"""`incsvr keys DIR`: an authority, a certificate and a Zenoh file for every role, for any prefix.

Nothing that is there is replaced unless that is asked for: a new authority makes every certificate of the old one
worthless. Each file is written under another name first, so that none is ever half there.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from incsvr.errors import BadInput
from service.bus.session import client_settings, listener_settings
from service.cli.output import add_json_argument, emit
from service.config.core_yaml import quote
from service.security.authority import VALIDITY_SPAN, Pair, authority, load, sign
from service.security.roles import CLIENTS, LEARNER, ROLES, access_control
from service.wire.json_text import json_text
from service.wire.section import Prefix

ENDPOINT = "tls/127.0.0.1:7447"
LOOPBACK = ("127.0.0.1", "::1", "localhost")
SECRET, PUBLIC = 0o600, 0o644


@dataclass(frozen=True, slots=True)
class Place:
    """The folder of the files, their folder on the machines that use them, and the learner's endpoint."""

    folder: Path
    used_in: Path
    endpoint: str
    prefixes: tuple[str, ...]

    def used(self, name: str) -> str:
        """The path of a file as a Zenoh file names it."""
        return str(self.used_in / name)


def may(role: str) -> tuple[str, ...]:
    """The rights of a role, in words."""
    return CLIENTS.get(role, ("listen", "answer", "publish"))


def sentence(role: str) -> str:
    return "it listens, answers and publishes." if role == LEARNER else f"it may {', '.join(may(role))}."


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", metavar="DIR", type=Path, help="folder of the files, such as /etc/incsvr/tls")
    parser.add_argument(
        "--prefix",
        metavar="KEYS",
        action="append",
        help="prefix of the keys (leng/yaw); again for further learners",
    )
    parser.add_argument(
        "--role", metavar="ROLE", action="append",
        help=f"this role alone, with the existing authority; repeatable; of {', '.join(ROLES)}",
    )  # fmt: skip
    parser.add_argument(
        "--listen", metavar="ENDPOINT", default=ENDPOINT, help=f"endpoint of the learner (default {ENDPOINT})"
    )
    parser.add_argument(
        "--name", metavar="HOST", action="append", default=[], help="further name or address of the learner; repeatable"
    )
    parser.add_argument("--owner", metavar="USER", help="owner of the keys, such as the unit's incsvr")
    parser.add_argument(
        "--place", metavar="DIR", type=Path, help="folder of the files on the machines that use them (DIR)"
    )
    parser.add_argument(
        "--replace", action="store_true", help="replace existing files; without --role the authority too"
    )
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    prefixes = tuple(_prefix(text) for text in args.prefix or ["leng/yaw"])
    folder = args.folder.absolute()
    place = Place(folder, (args.place or folder).absolute(), args.listen, prefixes)
    _check_roles(args.role or ())
    hosts = tuple(dict.fromkeys((_host(args.listen), *args.name, *LOOPBACK)))
    try:
        made = make(place, hosts, args.role, owner=args.owner, replace=args.replace)
    except OSError as error:
        raise BadInput(
            f"{error.filename or folder} cannot be written ({error.strerror}); name another folder"
        ) from None
    result = {
        "folder": str(folder),
        "prefixes": list(prefixes),
        "listen": place.endpoint,
        "hosts": list(hosts),
        "roles": {role: {"zenoh_file": place.used(f"{role}.json5"), "may": list(may(role))} for role in made},
    }
    emit(args, result, _summary(place, made))
    return 0


def make(
    place: Place, hosts: Sequence[str], only: Sequence[str] | None = None, *, owner: str | None, replace: bool
) -> tuple[str, ...]:
    """Writes the files of the roles, of all where `only` is None, and returns the roles.

    Raises:
        BadInput: something is there already, the authority is damaged, or the owner is not possible.
    """
    roles = tuple(role for role in ROLES if only is None or role in only)
    folder = place.folder
    there = (folder / "ca.pem").exists() or (folder / "ca.key").exists()
    if there and only is None and not replace:
        raise BadInput(
            f"{folder} already contains an authority: name what to add with --role, or replace it and every key with "
            "--replace"
        )
    for role in roles:
        if (folder / f"{role}.key").exists() and not replace:
            raise BadInput(f"{folder} already contains a key of the {role}; --replace makes a new one")
    if owner is not None:
        _check_owner(owner)
    by = _authority(folder) if there and only is not None else authority()
    folder.mkdir(parents=True, exist_ok=True)
    if not there or only is None:
        _write(folder / "ca.key", by.key_pem, SECRET)
        _write(folder / "ca.pem", by.certificate_pem, PUBLIC)
    for role in roles:
        pair = sign(by, role, hosts, server=role == LEARNER)
        _write(folder / f"{role}.key", pair.key_pem, SECRET, owner)
        _write(folder / f"{role}.pem", pair.certificate_pem, PUBLIC)
        _write(folder / f"{role}.json5", zenoh_file(role, place).encode(), PUBLIC)
    return roles


def zenoh_file(role: str, place: Place) -> str:
    """The Zenoh configuration of a program in this role, as the text of a JSON5 file."""
    of = "listen" if role == LEARNER else "connect"
    tls = {
        "root_ca_certificate": place.used("ca.pem"),
        f"{of}_certificate": place.used(f"{role}.pem"),
        f"{of}_private_key": place.used(f"{role}.key"),
        "enable_mtls": True,
        "verify_name_on_connect": True,
    }
    settings = listener_settings(place.endpoint) if role == LEARNER else client_settings(place.endpoint)
    # Only TLS: without this a plain TCP endpoint could be added by mistake.
    settings["transport"]["link"] |= {"protocols": ["tls"], "tls": tls}
    if role == LEARNER:
        settings["access_control"] = access_control(place.prefixes)
    head = f"// The {role} of {', '.join(place.prefixes)}, made by `incsvr keys`: {sentence(role)}\n"
    return head + _short_lists(json_text(settings, indent=2)) + "\n"


def _short_lists(text: str) -> str:
    """JSON with every list of plain values on one line."""
    return re.sub(r"\[\s+([^][{}]+?)\s+\]", lambda found: f"[{re.sub(chr(10) + ' +', ' ', found[1])}]", text)


def _check_roles(only: Sequence[str]) -> None:
    """Raises BadInput where a role is unknown."""
    unknown = [role for role in only if role not in ROLES]
    if unknown:
        raise BadInput(f"--role {unknown[0]}: there is no such role; choose from {', '.join(ROLES)}")


def _authority(folder: Path) -> Pair:
    """The authority that is there."""
    try:
        return load((folder / "ca.pem").read_bytes(), (folder / "ca.key").read_bytes())
    except (OSError, ValueError) as error:
        raise BadInput(
            f"the authority in {folder} (ca.pem, ca.key) cannot be used: {error}; bring both files back, or make all "
            "keys anew with --replace and without --role"
        ) from None


def _check_owner(owner: str) -> None:
    import pwd

    try:
        user = pwd.getpwnam(owner).pw_uid
    except KeyError:
        raise BadInput(f"--owner {owner}: there is no such user; `useradd --system {owner}` makes one") from None
    if os.geteuid() not in (0, user):
        raise BadInput(f"--owner {owner}: only root gives files to another user; run this with sudo")


def _write(path: Path, content: bytes, mode: int, owner: str | None = None) -> None:
    """A file that is whole or not there, and never readable by others; its owner is that of the file it replaces."""
    new = path.with_name(f".{path.name}.new")
    new.unlink(missing_ok=True)
    with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, SECRET), "wb") as file:
        file.write(content)
    if owner is not None:
        shutil.chown(new, owner)
    elif path.exists() and os.geteuid() == 0:
        os.chown(new, path.stat().st_uid, path.stat().st_gid)
    new.chmod(mode)
    new.replace(path)


def _prefix(text: str) -> str:
    try:
        return TypeAdapter(Prefix).validate_python(text)
    except ValidationError as error:
        reason = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise BadInput(f"--prefix {quote(text)}: {reason}") from None


def _host(endpoint: str) -> str:
    """The host of tls/HOST:PORT."""
    found = re.fullmatch(r"tls/(?:\[([0-9a-fA-F:.]+)\]|([^\s:/\[\]]+)):\d{1,5}", endpoint)
    if found is None:
        raise BadInput(f"--listen {endpoint}: name a TLS endpoint, such as tls/192.168.2.2:7447")
    return found[1] or found[2]


def _summary(place: Place, roles: Sequence[str]) -> str:
    """The summary of the files, with the commands that use them."""
    years = VALIDITY_SPAN.days // 365
    lines = [f"{place.folder}: keys for {', '.join(place.prefixes)} at {place.endpoint}, good for {years} years"]
    width = max(len(role) for role in roles)
    lines += [f"  {role:{width}}  {sentence(role)}" for role in roles]
    lines.append("Each role has a key (.key), a certificate (.pem) and a Zenoh file (.json5) that names both.")
    lines.append("Only its owner can read a key.")
    if LEARNER in roles and (place.folder / f"{LEARNER}.key").stat().st_uid == 0:
        lines[-1] = "Only root can read the keys. A unit of another user needs --role learner --owner USER --replace."
    if LEARNER in roles:
        lines.append(f"The learner:  incsvr serve --set bus.zenoh_file={place.used('learner.json5')}")
    clients = [role for role in roles if role in CLIENTS]
    if clients:
        lines.append(f"A client:     incsvr query 0.1 --set bus.zenoh_file={place.used(f'{clients[-1]}.json5')}")
        lines.append("A client's machine needs ca.pem and the three files of its role, in the same folder.")
    lines.append("Keep ca.key away from the vehicle: whoever has it can make every role.")
    return "\n".join(lines)
