"""The roles and their rights on a secured bus, and Zenoh's access control made from them.

The learner's session listens, so it judges every message that a client sends (ingress) and every message that it sends
to a client (egress). What no action names is denied. A role is the common name of a client's certificate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from service.wire.keys import QUERIES

LEARNER = "learner"


@dataclass(frozen=True, slots=True)
class Kind:
    """A way to use a key: the messages that come from the client for it, and those that go to the client."""

    name: str
    ingress: tuple[str, ...]
    egress: tuple[str, ...]


# The learner's own wish to receive must reach the client: a publisher sends nothing that nobody has subscribed to.
PUBLISH = Kind("publish", ("put",), ("declare_subscriber",))
FOLLOW = Kind("follow", ("declare_subscriber",), ("put",))
ASK = Kind("ask", ("query",), ("reply", "declare_queryable"))
PRESENCE = Kind("presence", ("liveliness_query", "declare_liveliness_subscriber"), ("liveliness_token",))


@dataclass(frozen=True, slots=True)
class Grant:
    """Keys below the prefix, and how they may be used."""

    keys: tuple[str, ...]
    kinds: tuple[Kind, ...]


def _with_history(*names: str) -> Grant:
    """The keys of Zenoh's history for late subscribers: `*` and `**` do not match its `@adv`."""
    return Grant(tuple(f"{name}/@adv/**" for name in names), (FOLLOW, ASK, PRESENCE))


ACTIONS: dict[str, tuple[Grant, ...]] = {
    "measure": (Grant(("rate", "torque", "channel/*"), (PUBLISH,)),),
    "see whether the learner is well": (Grant(("alive",), (PRESENCE,)), Grant(("health",), (ASK, FOLLOW))),
    "use the model": (
        Grant(QUERIES, (ASK,)),
        Grant(("estimate", "event"), (FOLLOW,)),
        Grant(("model", "coefficients"), (ASK, FOLLOW)),
        _with_history("model"),
    ),
    # Whatever is published below the prefix, so that one subscription to all of it is served, too.
    "watch the learning": (
        Grant(("**",), (FOLLOW,)),
        Grant(("iteration", "effects"), (ASK,)),
        _with_history("iteration"),
    ),
    # Keys of their own: access control sees the key of a query but not its parameters.
    "decide on effects": (Grant(("effects/promote", "effects/withdraw"), (ASK,)),),
}
"""The actions of clients. No action lets it answer a query, publish a model or declare a liveliness token."""

CLIENTS: dict[str, tuple[str, ...]] = {
    "vehicle": ("measure", "see whether the learner is well", "use the model"),
    "viewer": ("see whether the learner is well", "use the model", "watch the learning"),
    "operator": ("see whether the learner is well", "use the model", "watch the learning", "decide on effects"),
}
"""The actions of every role but the learner's, which listens and is bound by no rule of its own session."""

ROLES = (LEARNER, *CLIENTS)


def access_control(prefixes: Sequence[str]) -> dict[str, Any]:
    """The section `access_control` of the learner's Zenoh file, for keys below these prefixes."""
    rules = []
    named: dict[str, list[str]] = {}
    for action, grants in ACTIONS.items():
        for number, grant in enumerate(grants):
            keys = [f"{prefix}/{key}" for prefix in prefixes for key in grant.keys]
            for kind in grant.kinds:
                for flow, messages in (("ingress", kind.ingress), ("egress", kind.egress)):
                    name = f"{action} {number}: {kind.name}, {flow}"
                    named.setdefault(action, []).append(name)
                    rules.append(
                        {
                            "id": name,
                            "permission": "allow",
                            "flows": [flow],
                            "messages": list(messages),
                            "key_exprs": keys,
                        }
                    )
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": [{"id": role, "cert_common_names": [role]} for role in CLIENTS],
        "policies": [
            {"subjects": [role], "rules": [name for action in actions for name in named[action]]}
            for role, actions in CLIENTS.items()
        ],
    }
