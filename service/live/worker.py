"""The work beside a learner that traces: who does it, what it is asked, and which of the recent data it is given."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from incsvr.learning.model import Model
from incsvr.numerics import Streams
from service.config.configuration import Config
from service.config.sections import Tracing
from service.live.tracing_state import FRESH_PART, TRIAL_PART, TracingState, Work


class Worker(Protocol):
    """A worker beside the learner, such as `service.live.tracing_process.TracingProcess` in a process of its own."""

    @property
    def has_ended(self) -> bool: ...
    def answer(self) -> Any: ...
    def close(self) -> None: ...


Begin = Callable[[Mapping[str, Any], Streams], Worker | None]


def recent_streams(streams: Streams, settings: Tracing, state: TracingState, work: Work, newest: float) -> Streams:
    """The part of the recent streams, name → (stamps [s], values), that the work due at `newest` [s] is about."""
    since = _since(settings, state, newest) if work == "prove" else newest - settings.window
    return {
        name: (t[(t >= since) & (t <= newest)], value[(t >= since) & (t <= newest)])
        for name, (t, value) in streams.items()
    }


def job(config: Config, state: TracingState, work: Work, newest: float, model: Model) -> dict[str, Any]:
    """The work that is due at `newest` [s], as `service.live.tracing_answer.answer` takes it; `model` is served."""
    coupled, smoothing = config.coupled(), config.signals.smoothing
    body = {} if coupled is None else {"body": coupled.to_dict(), "smoothing": smoothing}
    surface = {} if model.several is None else {"surface": model.to_dict()}
    return body | surface | _job(config, state, work, newest)


def _job(config: Config, state: TracingState, work: Work, newest: float) -> dict[str, Any]:
    if work == "trace" or state.under_test is None:
        return {
            "work": work,
            "inertia": config.vehicle.inertia,
            "axis": config.vehicle.axis,
            "rate_limit": config.vehicle.rate_limit,
            "torque": config.signals.torque,
            "half": newest - 0.5 * config.tracing.window,
            "shortest": FRESH_PART * config.tracing.window,
        }
    role, content = state.under_test
    return {
        "work": work,
        "fresh": _fresh(config.tracing, state, newest),
        "closed": content.loop != "open",
        "without": None if role == "active" or state.active is None else state.active.model,
        "effects": content.model,
    }


def _fresh(settings: Tracing, state: TracingState, newest: float) -> float:
    """The begin of the data of a proof that are unseen by its effects [s]: of suspected ones all since their trace."""
    traced = state.traced_until
    return newest - TRIAL_PART * settings.window if state.suspect is None or traced is None else traced


def _since(settings: Tracing, state: TracingState, newest: float) -> float:
    """The begin of the data of a proof [s]: no earlier than those in which its effects were found."""
    begins, under_test = _fresh(settings, state, newest) - (1.0 - TRIAL_PART) * settings.window, state.under_test
    since = None if under_test is None else under_test[1].since
    return begins if since is None else max(begins, since)
