"""The page Health: how the learner does, and the ledger of the effects that it traced."""

from __future__ import annotations

import rerun as rr

from service.wire import EffectsLedger, Health
from viewer.frame import clock_text
from viewer.palette import LIGHT, Palette
from viewer.recorder import Recorder

SIGNS = {"OK": "OK", "WARN": "WARNING", "ERROR": "ERROR", "STALE": "NO DATA"}
AWAY = "AWAY"


class HealthPage:
    """Logs signals/health and effects/ledger."""

    def __init__(self, rec: Recorder, palette: Palette) -> None:
        self._rec = rec
        self._level = ""
        rec.log(
            "signals/health/level",
            rr.StateConfiguration(
                values=[*SIGNS, AWAY],
                labels=[*SIGNS.values(), "LEARNER AWAY"],
                colors=[palette.support, palette.forgotten, palette.new, palette.discarded, palette.outlier],
            ),
            static=True,
        )
        rec.log(
            "signals/health/learned",
            rr.SeriesLines(colors=LIGHT.support, names="Learned share", widths=2.5),
            static=True,
        )
        rec.log(
            "effects/ledger", rr.TextDocument(ledger_text(EffectsLedger()), media_type="text/markdown"), static=False
        )

    def log(self, health: Health) -> None:
        """The learner's health, at the clocks that are set."""
        self._rec.log("signals/health/now", rr.TextDocument(health_text(health), media_type="text/markdown"))
        self._rec.log("signals/health/learned", rr.Scalars(health.learned))
        self._switch(health.level)

    def away(self, sentence: str) -> None:
        """The learner does not answer, at the clocks that are set."""
        text = f"# LEARNER AWAY\n\n{sentence}"
        self._rec.log("signals/health/now", rr.TextDocument(text, media_type="text/markdown"))
        self._switch(AWAY)

    def effects(self, ledger: EffectsLedger) -> None:
        """The ledger, at the clocks that are set."""
        self._rec.log("effects/ledger", rr.TextDocument(ledger_text(ledger), media_type="text/markdown"))

    def _switch(self, level: str) -> None:
        if level != self._level:
            self._level = level
            self._rec.log("signals/health/level", rr.StateChange(state=level))


def health_text(health: Health) -> str:
    """Markdown; the level large, then why, then every counter."""
    counters = [
        f"| {name.replace('_', ' ').replace(':', ': ')} | {count} |" for name, count in sorted(health.counters.items())
    ]
    streams = [
        f"| {name} | {one.received} | {one.lost} | {'-' if one.t is None else clock_text(one.t)} |"
        for name, one in sorted(health.streams.items())
    ]
    return "\n".join(
        [
            f"# {SIGNS[health.level]}",
            *(f"- {reason[:1].upper()}{reason[1:]}." for reason in health.reasons),
            "" if health.reasons else "Nothing to report.",
            f"\n**Learned: {100 * health.learned:.0f} % of the yaw rate range** · iteration {health.iteration} · "
            f"revision {health.revision} · started as {health.boot}",
            "\n| Stream | Samples | Lost | Newest |\n|:--|--:|--:|--:|",
            *streams,
            "\n| Counter | Since start |\n|:--|--:|",
            *counters,
        ]
    )


def ledger_text(ledger: EffectsLedger) -> str:
    """Markdown: the effects in force, then every step that led there."""
    lines = ["# Traced effects", ""]
    if not ledger.effects:
        lines.append("None: the model is the declared inertia and the learned damping.")
    for effect in ledger.effects:
        lines.append(f"## {str(effect.get('effect', '?')).replace('_', ' ')}")
        if effect.get("sentence"):
            lines.append(str(effect["sentence"]))
        intervals = effect.get("interval") or {}
        for name, value in (effect.get("parameters") or {}).items():
            low_high = intervals.get(name)
            between = f" ({low_high[0]:.3g} to {low_high[1]:.3g})" if low_high else ""
            lines.append(f"- {name}: {value:.3g}{between}" if isinstance(value, float) else f"- {name}: {value}")
        if effect.get("share") is not None:
            lines.append(
                f"- {100 * effect['share']:.0f} % of what could be explained, p = {effect.get('p_value', 0):.1g}"
            )
    if ledger.history:
        names = list(dict.fromkeys(key for step in ledger.history for key in step))
        lines += ["\n## Ledger", "| " + " | ".join(names) + " |", "|" + ":--|" * len(names)]
        lines += [
            "| " + " | ".join(_cell(step.get(name, "")) for name in names) + " |" for step in ledger.history[-30:]
        ]
    return "\n".join(lines)


def _cell(value: object) -> str:
    text = f"{value:.4g}" if isinstance(value, float) else str(value)
    return text.replace("|", "/").replace("\n", " ")
