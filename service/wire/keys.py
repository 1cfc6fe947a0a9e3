"""The key names below a prefix."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Keys:
    """The key names below a prefix such as `leng/yaw`."""

    prefix: str

    @property
    def file_name(self) -> str:
        """The begin of the names of files with messages below the prefix."""
        return self.prefix.replace("/", "-")

    @property
    def rate(self) -> str:
        return f"{self.prefix}/rate"

    @property
    def torque(self) -> str:
        return f"{self.prefix}/torque"

    @property
    def any_channel(self) -> str:
        return f"{self.prefix}/channel/*"

    @property
    def model(self) -> str:
        return f"{self.prefix}/model"

    @property
    def iteration(self) -> str:
        return f"{self.prefix}/iteration"

    @property
    def coefficients(self) -> str:
        return f"{self.prefix}/coefficients"

    @property
    def damping(self) -> str:
        return f"{self.prefix}/damping"

    @property
    def forecast(self) -> str:
        return f"{self.prefix}/forecast"

    @property
    def feedforward(self) -> str:
        return f"{self.prefix}/feedforward"

    @property
    def estimate(self) -> str:
        return f"{self.prefix}/estimate"

    @property
    def event(self) -> str:
        return f"{self.prefix}/event"

    @property
    def health(self) -> str:
        return f"{self.prefix}/health"

    @property
    def effects(self) -> str:
        return f"{self.prefix}/effects"

    @property
    def promote(self) -> str:
        return f"{self.effects}/promote"

    @property
    def withdraw(self) -> str:
        return f"{self.effects}/withdraw"

    @property
    def alive(self) -> str:
        return f"{self.prefix}/alive"

    def coming(self, name: str) -> str:
        """The key of the token of a learner that starts."""
        return f"{self.prefix}/coming/{name}"

    def stream(self, name: str) -> str:
        """The key of an input stream: `yaw_rate`, `torque`, else a further channel of that name."""
        return {"yaw_rate": self.rate, "torque": self.torque}.get(name, f"{self.prefix}/channel/{name}")
