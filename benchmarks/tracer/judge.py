"""How an answer of the tracer is judged against what was hidden."""

from __future__ import annotations

from collections.abc import Collection, Mapping

VERDICTS = {
    "right": "the named set is the hidden set",
    "class": "a hidden effect is not named, but a named one says that this recording cannot tell the two apart",
    "joint": "likewise, but the named one is hidden, too, or stands for another: it is one of the two, or both at once",
    "missed": "a hidden effect is neither named nor in the class of a named one",
    "false": "all that is hidden is there, and something else is named beside it",
    "both": "a hidden effect is missed and something else is named",
}
GOOD = ("right", "class")
"""What is counted as found; `joint` is counted beside it: if either of two explains a recording, so do both at once."""


def judge(hidden: Collection[str], named: Mapping[str, Collection[str]]) -> str:
    """One of VERDICTS.

    Args:
        hidden: names of the effects that were hidden.
        named: every named effect with what it cannot be told from.
    """
    wanted, found = set(hidden), set(named)
    if wanted == found:
        return "right"
    # A named effect that is not hidden itself stands for one hidden effect; for more, and beside itself, but jointly.
    spare, missing, joint = found - wanted, 0, 0
    for effect in sorted(wanted - found):
        stand_in = next((name for name in sorted(spare) if effect in named[name]), None)
        if stand_in is not None:
            spare.discard(stand_in)
        elif any(effect in rivals for rivals in named.values()):
            joint += 1
        else:
            missing += 1
    if missing:
        return "both" if spare else "missed"
    return "false" if spare else "joint" if joint else "class"
