"""Whether a learner could use what its configuration names, by the rights of the user that will run it.

A Zenoh file is good when its certificates and keys can be read, when the certificates are valid now, and when its
access control speaks of the configured prefix.
"""

from __future__ import annotations

import getpass
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import zenoh

from incsvr.errors import BadInput
from service.bus.session import certificates, endpoints, from_file, section, tls_files
from service.config.configuration import Config
from service.config.sections import Bus
from service.state.disk_refusals import OTHER_STATE, unwritable, user_name
from service.wire import Keys


@contextmanager
def reading_as(user: str | None) -> Iterator[None]:
    """A context in which files are opened with this user's rights; only root can take another user's.

    Raises:
        BadInput: there is no such user, or we may not.
    """
    if user is None or user == getpass.getuser():
        yield
        return
    import pwd

    try:
        entry = pwd.getpwnam(user)
    except KeyError:
        raise BadInput(f"--user {user}: there is no such user; `useradd --system {user}` makes one") from None
    if os.geteuid() != 0:
        raise BadInput(f"--user {user}: only root can check another user's rights; run this with sudo")
    groups, group = os.getgroups(), os.getegid()
    os.initgroups(user, entry.pw_gid)
    os.setegid(entry.pw_gid)
    os.seteuid(entry.pw_uid)
    try:
        yield
    finally:
        os.seteuid(0)
        os.setegid(group)
        os.setgroups(groups)


def check_files(config: Config, path: Path, user: str | None) -> None:
    """Whether this user can read all that the configuration in `path` names, and write its state.

    Raises:
        BadInput: the first file that it cannot read or write, and the cure.
    """
    named = [("the configuration", path)]
    zenoh_file = config.bus.zenoh_file
    if zenoh_file is not None:
        named.append(("bus.zenoh_file", zenoh_file))
        with suppress(BadInput):  # a file that is missing or wrong is said when it is opened below, or by check_bus
            named += [(f"{zenoh_file}: {name}", file) for name, file in tls_files(from_file(zenoh_file)).items()]
    for each in config.each():
        named += [(f"validation.{name}", recording) for name, recording in each.validation.items()]
        named += [("effects", each.effects)] if each.effects is not None else []
    with reading_as(user):
        for what, file in named:
            _check_readable(file, what)
        for each in config.each():
            _check_state(each.state)


def check_bus(bus: Bus, prefixes: Sequence[str]) -> str:
    """The learner's endpoint in words, once the configuration of the bus has passed all checks.

    Raises:
        BadInput: the first thing in `bus.zenoh_file` that would keep it from being met.
    """
    path = bus.zenoh_file
    if path is None:
        return f"as a client of {bus.connect}" if bus.connect is not None else f"at {bus.listen}"
    config = from_file(path)
    for each in certificates(config):
        if each.refused_now:
            raise BadInput(f"{path}: {each.sentence_now()}")
    listened = endpoints(config, "listen")
    _check_access(config, path, prefixes)
    where = f"at {', '.join(listened)}" if listened else f"as {path} says"
    return "; ".join([where, *(said for each in certificates(config) if (said := each.sentence_now()) is not None)])


def _check_state(state: Path | None) -> None:
    """The directory of the durable state, or where it will be made, must be writable."""
    why_not = None if state is None else unwritable(state, OTHER_STATE)
    if why_not is not None:
        raise BadInput(f"state: {why_not}")


def _check_readable(path: Path, what: str) -> None:
    try:
        path.read_bytes()
    except FileNotFoundError:
        raise BadInput(f"{what}: {path}: there is no such file") from None
    except PermissionError:
        raise BadInput(f"{what}: {path} cannot be read by {user_name()}: {_obstacle(path)}") from None
    except OSError as error:
        raise BadInput(f"{what}: {path} cannot be read ({error.strerror})") from None


def _obstacle(path: Path) -> str:
    """The obstacle that keeps this process from a file, and the cure."""
    for place in (path, *path.absolute().parents):
        try:
            found = place.stat()
        except PermissionError:
            continue
        mode = f"mode {found.st_mode & 0o777:04o}"
        if place == path:
            return (
                f"its owner is {user_name(found.st_uid)}, its mode {mode}; `chown {user_name()} {path}` gives it to "
                f"{user_name()}"
            )
        return f"the folder {place} is closed to others, {mode}; `chmod a+x {place}` opens it"
    return "the folders above it are closed to others"


def _check_access(config: zenoh.Config, path: Path, prefixes: Sequence[str]) -> None:
    """Refuses access control that allows nobody to publish measurements below a prefix."""
    access = section(config, "access_control") or {}
    if not access.get("enabled") or access.get("default_permission") == "allow":
        return
    allowed = [
        zenoh.KeyExpr(key)
        for rule in access.get("rules") or ()
        if rule["permission"] == "allow" and "put" in rule["messages"] and "ingress" in rule["flows"]
        for key in rule["key_exprs"]
    ]
    for prefix in prefixes:
        keys = Keys(prefix)
        for key in (keys.rate, keys.torque):
            if not any(each.includes(zenoh.KeyExpr(key)) for each in allowed):
                listen = "".join(f" --listen {each}" for each in endpoints(config, "listen")[:1])
                every = "".join(f" --prefix {each}" for each in prefixes)
                raise BadInput(
                    f"{path}: its access control allows nobody to publish {key}; make keys for this prefix with "
                    f"`incsvr keys {path.parent}{every}{listen} --role learner --replace`"
                )
