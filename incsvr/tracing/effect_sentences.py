"""An effect of the catalogue in plain words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from incsvr.effects import Effect, Signals
from incsvr.model_trace.sentences import AHEAD, LABELS
from incsvr.plant.words import YAW_WORDS, AxisWords


def next_manoeuvre(effect: Effect, others: Sequence[str], words: AxisWords = YAW_WORDS) -> str:
    """What a log must show to distinguish an effect from the others that explain this one as well, or that none can."""
    if others:
        return f"to distinguish it from {others[0]}, the log must show {words.fill(effect.shown_by)}"
    if effect.ties:
        return (
            f"no manoeuvre in {words.name} distinguishes it from {effect.ties[0]}: both explain every motion alike; "
            "measure one of the two by other means (a bollard pull, a pendulum test)"
        )
    return ""


def sentence(
    effect: Effect,
    parameters: Mapping[str, float],
    interval: Mapping[str, tuple[float, float]],
    explained_part: float,
    words: AxisWords = YAW_WORDS,
) -> str:
    """The sentence of a finding: its values with 95 % intervals, and its share of the better fit."""
    values = []
    for name, value in parameters.items():
        label, unit = (words.fill(each) for each in LABELS[name])
        low, high = interval[name]
        certain = high - low <= 0.0
        spread = "" if certain else f" ({low:.3g} to {high:.3g})"
        values.append(f"{label} {value:.3g}{spread}{' ' + unit if unit else ''}")
    meaning = words.fill(AHEAD if parameters.get("delay_s", 0.0) < 0.0 else effect.sentence)
    part = f"It accounts for {100.0 * explained_part:.0f} % of the better fit."
    return f"{effect.name}: {meaning}; {', '.join(values)}. {part}"


def streams(effect: Effect) -> tuple[str, ...]:
    """The streams that an effect reads, for the contract's `channels`."""
    if effect.channels:
        return effect.channels
    if effect.acts == "thrust":
        return ("torque",)
    if effect.name in ("heading_current", "tether"):
        return ("heading",)
    if effect.name == "inflow":
        return ("yaw_rate", "torque")
    if effect.needs_clock:
        return ("t",)
    return () if effect.acts == "outside" else ("yaw_rate",)


def of_clocks(signals: Signals) -> tuple[str, ...]:
    """The note that nothing was sought that changes in time; empty where the recordings follow one another."""
    if signals.one_clock:
        return ()
    return (
        "the stamps of the recordings overlap, so each has its own time: effects that begin or drift were not "
        "sought; recordings of one dive need stamps that continue from one to the next",
    )
