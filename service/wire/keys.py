"""The key names below a prefix."""

from __future__ import annotations

from dataclasses import dataclass

QUERIES = ("damping", "forecast", "feedforward")
"""The names of the keys that answer about the model, and publish nothing."""


class Below:
    """A key: its name below the prefix."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __get__(self, keys: Keys, kind: type[Keys]) -> str:
        return f"{keys.prefix}/{self._name}"


@dataclass(frozen=True, slots=True)
class Keys:
    """The key names below a prefix such as `leng/yaw`."""

    prefix: str

    rate = Below("rate")
    torque = Below("torque")
    any_channel = Below("channel/*")
    model = Below("model")
    iteration = Below("iteration")
    coefficients = Below("coefficients")
    damping = Below("damping")
    forecast = Below("forecast")
    feedforward = Below("feedforward")
    estimate = Below("estimate")
    event = Below("event")
    health = Below("health")
    effects = Below("effects")
    promote = Below("effects/promote")
    withdraw = Below("effects/withdraw")
    alive = Below("alive")

    @property
    def file_name(self) -> str:
        """The begin of the names of files with messages below the prefix."""
        return self.prefix.replace("/", "-")

    def coming(self, name: str) -> str:
        """The key of the token of a learner that starts."""
        return f"{self.prefix}/coming/{name}"

    def stream(self, name: str) -> str:
        """The key of an input stream: `yaw_rate`, `torque`, else a further channel of that name."""
        return {"yaw_rate": self.rate, "torque": self.torque}.get(name, f"{self.prefix}/channel/{name}")
