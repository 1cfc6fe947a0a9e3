"""The cases of the second simulator. A group, an index and a first seed name one, whatever else is tried beside it.

Consecutive cases go through the effects. 36 hold every effect under both kinds of torque, 90 every effect on every
vehicle, 126 every effect under every command, and 1260 every cell; of the quiet ones 70 hold every cell.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from simulator.second import BY_CHANNEL, COMMANDS, EFFECTS, VEHICLES, Case, Outcome, play
from simulator.second.channels import CHANNELS

__all__ = ["GROUPS", "KINDS", "Case", "Outcome", "case", "play"]

GROUPS = {
    "one": "one effect of realistic size",
    "quiet": "nothing hidden",
    "half": "one effect at half the size",
}
SIZES = {"one": 1.0, "quiet": 0.0, "half": 0.5}
KINDS = (*EFFECTS, *BY_CHANNEL)
TORQUES: tuple[Literal["commanded", "measured"], ...] = ("commanded", "measured")
WITH_COMPASS = 0.8


def case(group: str, index: int, first_seed: int, duration: float = 720.0) -> Case:
    """The `index`-th case of a group.

    Raises:
        KeyError: no group has this name.
    """
    size = SIZES[group]
    seed = first_seed + index
    random = np.random.default_rng(np.random.SeedSequence([seed, *b"case"]))
    kind, cell = ("", index) if group == "quiet" else (KINDS[index % len(KINDS)], index // len(KINDS))
    # The counts of commands, vehicles and torques share no divisor, so that one counter goes through all their cells.
    # It begins elsewhere for each effect, so that few cases hold as many cells as they can.
    cell += KINDS.index(kind) if kind else 0
    effects: tuple[str, ...] = (_with_channel(kind, random),) if kind else ()
    needed = {effect.partition(":")[2] for effect in effects} - {""}
    idle = random.permutation([name for name in CHANNELS if name not in needed])[: random.integers(1, 4)]
    return Case(
        seed=seed,
        vehicle=tuple(VEHICLES)[cell % len(VEHICLES)],
        command=COMMANDS[cell % len(COMMANDS)],
        torque=TORQUES[cell % len(TORQUES)],
        effects=effects,
        size=size,
        channels=(*sorted(needed), *(str(name) for name in idle)),
        compass=bool(random.random() < WITH_COMPASS),
        duration=duration,
    )


def _with_channel(kind: str, random: np.random.Generator) -> str:
    return f"{kind}:{random.choice(BY_CHANNEL[kind])}" if kind in BY_CHANNEL else kind
