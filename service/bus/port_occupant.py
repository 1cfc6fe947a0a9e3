"""The program that occupies the port of a learner, and the cure."""

from __future__ import annotations

from collections.abc import Sequence

import zenoh

from service.bus.session import client_settings
from service.wire import Keys
from service.wire.json_text import json_text

ANSWER_PATIENCE_S = 1.0
"""The time that who is there may take to answer [s]; a bus answers within a tenth."""


def port_in_use(listened: Sequence[str], tls: bool) -> str:
    """A sentence on the program that occupies the first of these endpoints, and the flags that help.

    Args:
        tls: a client would need a certificate to ask who is there.
    """
    endpoint = listened[0] if listened else "the endpoint"
    elsewhere = "listen at another port with --listen"
    if tls:
        return (
            f"{endpoint} is in use, by another learner or a router; `incsvr status` with the viewer's zenoh_file shows "
            "a learner, `ss -ltnp` any program; end it, or make keys for another port (`incsvr keys --listen`)"
        )
    found = _learners(endpoint)
    if found is None:
        return f"{endpoint} is in use by a program that does not answer as a bus (`ss -ltnp` names it); {elsewhere}"
    if not found:
        return (
            f"{endpoint} is in use by a Zenoh router or program without a learner, as on a vehicle with BlueOS; be its "
            f"client with --connect {endpoint}, or {elsewhere}"
        )
    return (
        f"{endpoint} is in use by the learner of {', '.join(found)}; `incsvr status --connect {endpoint} --prefix "
        f"{found[0]}` shows it; end it, {elsewhere}, or be its client under another prefix with --connect {endpoint}"
    )


def _learners(endpoint: str) -> list[str] | None:
    """The prefixes of the learners on the bus there; None where there is no bus."""
    settings = client_settings(endpoint)
    settings["transport"]["unicast"] = {"open_timeout": int(1000 * ANSWER_PATIENCE_S)}
    try:
        session = zenoh.open(zenoh.Config.from_json5(json_text(settings)))
    except zenoh.ZError:
        return None
    with session:
        alive = Keys("**").alive
        replies = session.liveliness().get(alive, timeout=ANSWER_PATIENCE_S)
        keys = [str(reply.ok.key_expr) for reply in replies if reply.ok is not None]
    return sorted(key.removesuffix("/alive") for key in keys)
