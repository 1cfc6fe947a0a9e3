"""The result of a trace: findings, rejected effects, errors, and the data that a report draws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from incsvr.numerics import Array
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.mass_and_coriolis import inertia_in_force
from incsvr.tracing.held_out import Errors, beats_zero
from incsvr.tracing.model import TracedModel


@dataclass(frozen=True, slots=True)
class UnexplainedChannel:
    """A smooth term of a channel that the residual follows."""

    channel: str
    p_value: float


@dataclass(frozen=True, slots=True)
class Finding:
    """An effect that the model lacked.

    Attributes:
        effect: name in the vocabulary.
        channels: the streams that it reads.
        parameters: physical values; units in the names.
        interval: 95 % interval of each.
        p_value: corrected for the search.
        share: of the residual's explainable variance.
        cannot_tell_from: alternatives that explain these recordings as well.
        next_manoeuvre: what a log must show to distinguish them; empty where it can name the effect.
        sentence: for people.
        thrust: of an effect between command and thrust, at commands up to the largest either way, rounded up: command,
            thrust and the ends of its 95 % interval [N m].
        shape: which of the shapes of an effect that has several; empty for its usual one.
    """

    effect: str
    channels: tuple[str, ...]
    parameters: dict[str, float]
    interval: dict[str, tuple[float, float]]
    p_value: float
    share: float
    cannot_tell_from: tuple[str, ...]
    next_manoeuvre: str
    sentence: str
    thrust: tuple[tuple[float, float, float, float], ...] = ()
    shape: str = ""

    def to_dict(self) -> dict[str, Any]:
        return {
            "effect": self.effect,
            "channels": list(self.channels),
            "parameters": self.parameters,
            "interval": {name: list(ends) for name, ends in self.interval.items()},
            "p_value": self.p_value,
            "share": self.share,
            "cannot_tell_from": list(self.cannot_tell_from),
            "next_manoeuvre": self.next_manoeuvre,
            "sentence": self.sentence,
            **({"thrust_nm": [list(each) for each in self.thrust]} if self.thrust else {}),
            **({"shape": self.shape} if self.shape else {}),
        }


@dataclass(frozen=True, slots=True)
class RejectedEffect:
    """A candidate that was looked at and not added.

    Attributes:
        effect: its name.
        p_value: corrected for the search.
        reason: why it was not added.
        refused: whether it predicted better, and was refused all the same.
    """

    effect: str
    p_value: float
    reason: str
    refused: bool = False


@dataclass(frozen=True, slots=True)
class Pictures:
    """The data that a report draws.

    Attributes:
        before: errors of the declared model with its learned damping, on unseen data.
        after: errors of the model with the effects, on unseen data.
        ledger_time: (n,) stamps of the ledger [s], on the fitted recordings.
        ledger: part → (n,) torque that it takes [N m]; of what was taken from the torque before, at stamps of its own.
        residual_before: (n_b,) block residuals on the fitted recordings [N m].
        residual_after: likewise.
        depends: name → (n_b,) block means of what the residual may depend on: rate, torque, heading, time, channels.
    """

    before: Errors
    after: Errors
    ledger_time: Array
    ledger: dict[str, Array]
    residual_before: Array
    residual_after: Array
    depends: dict[str, Array]


@dataclass(frozen=True, slots=True)
class Trace:
    """The findings of a trace and their proof; `to_dict` is CONTRACT Section 5.

    Attributes:
        inertia: declared [kg m²].
        verdict: `none`, `effects` or `unexplained`.
        effects: in the order in which they were added.
        rejected: candidates that were not added, and why.
        unexplained: channels of which a smooth term still predicts the residual.
        error: before, after, change and floor on unseen data.
        ignored_channels: name → why it is no candidate.
        notes: what else the reader must know.
        declared_model: the declared model with its learned damping.
        model: the same with the effects.
        pictures: for the report.
        loop: "closed" where the torque answers the rate, else "open".
        proven: in open loop, whether the interval of the free run's change lies below zero; in closed loop, where a
            free run proves nothing, that of the predictions' change; and the model beats a rate of zero.
        spans: where what is left is larger than elsewhere, from and to [s of the recordings].
        sought: whether effects were looked for: not where the log lacks the gyro that the controller reads.
        one_clock: whether the recordings follow one another; else nothing that changes in time was sought.
        doubts: what speaks against the declaration itself (inertia, unit or sign of the torque), each a clause that
            stands below the headline.
        axis: the one that is traced, of whose quantities the sentences speak.
    """

    inertia: float
    verdict: str
    effects: tuple[Finding, ...]
    rejected: tuple[RejectedEffect, ...]
    unexplained: tuple[UnexplainedChannel, ...]
    error: dict[str, Any]
    ignored_channels: dict[str, str]
    notes: tuple[str, ...]
    declared_model: TracedModel
    model: TracedModel
    pictures: Pictures
    loop: str = "open"
    proven: bool = False
    spans: tuple[tuple[float, float], ...] = ()
    one_clock: bool = True
    sought: bool = True
    doubts: tuple[str, ...] = ()
    axis: Axis = YAW

    @property
    def beats_zero(self) -> bool:
        """Whether the free run with what was found errs less than saying that the vehicle does not turn."""
        return beats_zero(self.error)

    @property
    def decisive_error(self) -> str:
        """The error on unseen data that proves: in closed loop that of the predictions, else of the free run."""
        return "torque_rmse" if self.loop == "closed" else "free_run_rmse"

    @property
    def inertia_in_force(self) -> float:
        """The inertia that the model goes by: the declared one with what was traced of it [kg m²]."""
        return inertia_in_force(self.inertia, [finding.to_dict() for finding in self.effects])

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "declared": {"inertia": self.inertia},
            "inertia": self.inertia_in_force,
            "verdict": self.verdict,
            "effects": [finding.to_dict() for finding in self.effects],
            "rejected": [{"effect": r.effect, "p_value": r.p_value, "reason": r.reason} for r in self.rejected],
            "unexplained": [{"channel": u.channel, "p_value": u.p_value} for u in self.unexplained],
            "error": self.error,
            "loop": self.loop,
            "proven": self.proven,
            "spans": [list(span) for span in self.spans],
            "ignored_channels": self.ignored_channels,
            "notes": list(self.notes),
            "model": self.model.to_dict(),
        }
