"""What the page knows of a learner: asked over the bus when a browser asks, as one JSON object."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

import numpy as np
import zenoh

from incsvr.errors import BadInput
from incsvr.learning.coefficients import coefficients, negative_drag
from incsvr.numerics.plain import to_plain
from incsvr.plant.axes import AXES, YAW, Axis
from incsvr.plant.words import words_of
from service.bus.session import answer, open_session
from service.inputs.units import si_unit
from service.wire import (
    EffectsLedger,
    FormType,
    Health,
    IterationHistory,
    IterationReport,
    Keys,
    ModelSnapshot,
)
from viewer import names

FRESH_S = 0.5
"""For so long an answer serves every browser [s]."""
ANSWER_TIMEOUT_S = 2.0
"""How long the learner may take [s]; it answers within a hundredth while it trains."""
CURVE_RATES = 121
"""At which the curve is drawn."""
BEYOND_SHARE = 0.1
"""Part of the trained range by which the curve is drawn beyond each of its ends."""
MAX_SEARCHED_ITERATIONS = 100
"""Iterations that are looked through for what the learner noticed."""
WORDS = {
    "title": "{title} damping",
    "curve": "Damping {moment} over {rate}",
    "rate": "{rate}",
    "torque": "{effort}",
    "rate_unit": "{rate_unit}",
    "torque_unit": "{effort_unit}",
    "inertia": "{inertia_symbol} = ",
    "inertia_unit": "{inertia_unit}",
    "linear": "{linear}, linear",
    "linear_unit": "{linear_unit}",
    "quadratic": "{quadratic}, quadratic",
    "quadratic_unit": "{quadratic_unit}",
}
"""What the page calls quantities and their units: templates of `AxisWords`."""
NOTHING_LEARNED: Mapping[str, Any] = {"model": None, "changes": []}
"""What is shown before anything was learned."""


class Learner:
    """A learner on a bus; `state` may be called from any thread."""

    def __init__(self, config: zenoh.Config, where: str, prefix: str, axis: Axis = YAW) -> None:
        self._axis = axis
        self.words = {key: words_of(axis).fill(text) for key, text in WORDS.items()}
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
        if axis not in self._beside and axis in AXES and prefix != own["prefix"]:
            other = Learner(self._config, self._where, prefix, AXES[axis])
            with self._lock:
                other._session = self._session
                self._beside.setdefault(axis, other)
        return self._beside[axis].state() if axis in self._beside else own

    def close(self) -> None:
        with self._lock:
            if self._session is not None:
                self._session.close()  # type: ignore[no-untyped-call]

    def state(self) -> dict[str, Any]:
        """Everything that the page shows.

        Where the learner does not answer, `away` says why, and `away_s` for how long [s], if it ever did. While one
        browser's question is on its way the others get the answer before: a learner that hangs holds up one of them.
        """
        if not self._lock.acquire(blocking=not self._told):
            return self._told
        try:
            if time.monotonic() > self._until:
                self._told = self._asked()
                self._until = time.monotonic() + FRESH_S
            return self._told
        finally:
            self._lock.release()

    def _asked(self) -> dict[str, Any]:
        head = {
            "prefix": self._keys.prefix,
            "where": self._where,
            "version": version("incsvr"),
            "words": self.words,
        }
        try:
            if self._session is None:
                self._session = open_session(self._config)
            health = self._ask(self._keys.health, Health)
        except BadInput as error:
            return head | self._parts | self._away(str(error))
        if health is None:
            return head | self._parts | self._away(f"no learner answers for {self._keys.prefix} at {self._where}")
        self._answered = time.monotonic()
        revision = (health.boot, health.revision)
        if revision != self._drawn:
            learned = self._learned() if health.revision else NOTHING_LEARNED
            if learned is not None:  # else the next browser's question asks again
                self._parts.update(learned)
                self._drawn = revision
        ledger = self._ask(self._keys.effects, EffectsLedger)
        if ledger is not None:
            self._parts |= {
                "effects": [names.finding(found) for found in ledger.effects],
                "found": [f"{found.get('state')}, not in force: {names.finding(found)}" for found in ledger.found],
                "history": [names.step(entry).replace("**", "") for entry in ledger.history[-10:]],
            }
        units = {name: si_unit(name) for name in health.streams}
        present = {"away": None, "away_s": None, "units": units, "health": to_plain(health)}
        return head | self._parts | present

    def _away(self, why: str) -> dict[str, Any]:
        since = None if self._answered is None else round(time.monotonic() - self._answered, 1)
        return {"away": why, "away_s": since}

    def _learned(self) -> Mapping[str, Any] | None:
        """The curve of the served model, and what the learner noticed about the vehicle; None where it does not say."""
        snapshot = self._ask(self._keys.model, ModelSnapshot)
        if snapshot is None:
            return None
        if not snapshot.model.is_trained:
            return NOTHING_LEARNED
        after = max(0, snapshot.revision - MAX_SEARCHED_ITERATIONS)
        history = self._ask(f"{self._keys.iteration}?after={after};limit={MAX_SEARCHED_ITERATIONS}", IterationHistory)
        if history is None:
            latest = self._ask(self._keys.iteration, IterationReport)
            history = IterationHistory(iterations=() if latest is None else (latest,), latest_revision=0)
        noticed = [each for each in history.iterations if each.change]
        changes = [{"iteration": each.iteration, "t": each.t, "what": each.change} for each in noticed[-10:]]
        return {"model": curve(snapshot, self._axis), "changes": changes}

    def _ask(self, selector: str, form: type[FormType]) -> FormType | None:
        """The learner's answer; None where it has none, as before anything is learned, or does not answer in time.

        Raises:
            BadInput: what answers is no learner of this version.
        """
        assert self._session is not None
        return answer(self._session, selector, form, ANSWER_TIMEOUT_S)


def curve(snapshot: ModelSnapshot, axis: Axis = YAW) -> Mapping[str, Any]:
    """What is drawn of a model: the damping with the bands of 95 %, the vectors, the textbook's coefficients."""
    model = snapshot.model
    low, high = model.trained_range or (0.0, 0.0)
    beyond = BEYOND_SHARE * (high - low)
    rate = np.linspace(low - beyond, high + beyond, CURVE_RATES)
    drawn, known, words = model.predict(rate), coefficients(model), words_of(axis)
    return {
        "revision": snapshot.revision,
        "iteration": snapshot.iteration,
        "t": snapshot.t,
        "inertia": snapshot.inertia_in_force,
        "trained_range": [low, high],
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
