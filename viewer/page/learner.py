"""What the page knows of a learner: asked over the bus when a browser asks, as one JSON object."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import zenoh

from incsvr.errors import BadInput
from incsvr.learning.coefficients import coefficients, negative_drag
from incsvr.numerics.plain import to_plain
from incsvr.plant.axes import AXES, YAW, Axis
from incsvr.plant.words import YAW_WORDS, AxisWords, words_of
from service.bus.session import open_session
from service.inputs.units import si_unit
from service.wire import Keys, ModelSnapshot
from viewer import names
from viewer.bus import Questions

FRESH_S = 0.5
"""For so long an answer serves every browser [s]."""
MAX_SEARCHED_ITERATIONS = 100
"""Iterations that are looked through for what the learner noticed."""
NOTHING_LEARNED: Mapping[str, Any] = {"model": None, "changes": []}
"""What is shown before anything was learned."""


class Learner:
    """A learner on a bus; `state` may be called from any thread."""

    def __init__(self, config: zenoh.Config, where: str, prefix: str, axis: Axis = YAW) -> None:
        self.words = words_of(axis)
        self.closed = threading.Event()
        self._config, self._where, self._keys = config, where, Keys(prefix)
        self._session: zenoh.Session | None = None
        self._lock = threading.Lock()
        self._told: dict[str, Any] = {}
        self._until = -1.0
        self._answered: float | None = None  # when the learner did last
        self._drawn: tuple[str, int] | None = None
        self._parts: dict[str, Any] = {}
        self._beside: dict[str, Learner] = {}  # by axis

    def of_axis(self, axis: str | None) -> dict[str, Any]:
        """The `state` of an axis of the vehicle that this learner's process learns too; else its own."""
        own = self.state()
        prefix = own.get("health", {}).get("axes", {}).get(axis, own["prefix"])
        with self._lock:
            if axis not in self._beside and axis in AXES and prefix != own["prefix"]:
                self._beside[axis] = Learner(self._config, self._where, prefix, AXES[axis])
                self._beside[axis]._session = self._session
        return self._beside[axis].state() if axis in self._beside else own

    def close(self) -> None:
        """Ends every answer that is open, and the session."""
        self.closed.set()
        with self._lock:
            if self._session is not None:
                self._session.close()  # type: ignore[no-untyped-call]

    def state(self) -> dict[str, Any]:
        """Everything that the page shows.

        Where the learner does not answer, `away` says why, and `away_s` for how long [s], if it ever did.
        """
        with self._lock:
            if time.monotonic() > self._until:
                head = {"prefix": self._keys.prefix, "words": asdict(self.words), "away": None, "away_s": None}
                try:
                    self._told = head | self._asked()
                except BadInput as error:
                    since = None if self._answered is None else round(time.monotonic() - self._answered, 1)
                    self._told = head | self._parts | {"away": str(error), "away_s": since}
                self._until = time.monotonic() + FRESH_S
            return self._told

    def _asked(self) -> dict[str, Any]:
        """What the learner says now.

        Raises:
            BadInput: it does not answer.
        """
        if self._session is None:
            self._session = open_session(self._config)
        learner = Questions(self._session, self._keys)
        health = learner.health()
        if health is None:
            raise BadInput(f"no learner answers for {self._keys.prefix} at {self._where}")
        self._answered = time.monotonic()
        revision = (health.boot, health.revision)
        if revision != self._drawn:
            learned = self._learned(learner) if health.revision else NOTHING_LEARNED
            if learned is not None:  # else the next browser's question asks again
                self._parts.update(learned)
                self._drawn = revision
        ledger = learner.ledger()
        if ledger is not None:
            self._parts |= {
                "effects": [names.finding(found) for found in ledger.effects],
                "found": [f"{found.get('state')}, not in force: {names.finding(found)}" for found in ledger.found],
                "history": [names.step(entry).replace("**", "") for entry in ledger.history[-10:]],
            }
        units = {name: si_unit(name) for name in health.streams}
        return self._parts | {"units": units, "health": to_plain(health)}

    def _learned(self, learner: Questions) -> Mapping[str, Any] | None:
        """The curve of the served model, and what the learner noticed about the vehicle; None where it does not say."""
        snapshot = learner.model()
        if snapshot is None:
            return None
        if not snapshot.model.is_trained:
            return NOTHING_LEARNED
        looked_through = learner.reports(max(0, snapshot.revision - MAX_SEARCHED_ITERATIONS))
        changes = [{"iteration": each.iteration, "what": each.change} for each in looked_through if each.change]
        return {"model": curve(snapshot, self.words), "changes": changes[-10:]}


def curve(snapshot: ModelSnapshot, words: AxisWords = YAW_WORDS, rates: int = 121) -> Mapping[str, Any]:
    """What is drawn of a model: the damping with the bands of 95 %, the vectors, the textbook's coefficients.

    The curve goes a tenth of the trained range beyond each of its ends.
    """
    model = snapshot.model
    low, high = model.trained_range or (0.0, 0.0)
    beyond = 0.1 * (high - low)
    rate = np.linspace(low - beyond, high + beyond, rates)
    drawn, known = model.predict(rate), coefficients(model)
    return {
        "revision": snapshot.revision,
        "iteration": snapshot.iteration,
        "t": snapshot.t,
        "inertia": snapshot.inertia_in_force,
        "noise": snapshot.noise,
        "rate": rate.tolist(),
        "damping": drawn.damping.tolist(),
        "sigma": drawn.sigma.tolist(),
        "doubt": drawn.doubt.tolist(),
        "extrapolated": drawn.extrapolated.tolist(),
        "support": {"rate": model.support_rate.tolist(), "damping": model.support_damping.tolist()},
        "coefficients": {name: value._asdict() for name, value in known.items()},
        "coefficient_notes": [
            note
            for name, value in zip((words.linear, words.quadratic), known.values(), strict=True)
            if (note := negative_drag(name, value.low, value.high)) is not None
        ],
    }
