"""The state that a learner continues: the one in its place, or one set aside earlier that fits again."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from incsvr.learning import learner
from service.config.configuration import Config
from service.state.state_file import StateDamage, StateFile
from service.wire.json_text import json_text

STATE_FORM = 2
"""The version of the tables and of what is in them."""
SIDE_FILE_ENDINGS = ("-journal", "-wal", "-shm")
"""The endings of the names of what SQLite keeps beside a file."""


def identity(config: Config, effects: str | None = None) -> dict[str, Any]:
    """The values that a state must have to be restored; `effects` names the effects subtracted from samples."""
    settings = config.learner_settings()
    coupled = config.coupled()
    inertia: Any = config.vehicle.inertia
    if coupled is not None:  # what samples are freed of, as JSON gives it back
        inertia = json.loads(json_text(coupled.to_dict()))
    return {
        "form": [STATE_FORM, learner.STATE_FORM],
        "vehicle": config.vehicle.name,
        "prefix": config.prefix,
        "inertia": inertia,
        "gamma": settings.gamma,
        "C": settings.C,
        "epsilon": settings.epsilon,
        "bins": settings.bins,
        "effects": effects,
    }


LOST_KEY = "lost"
"""The key beside the identity in a state of the first and the last revision of each gap in its history."""


@dataclass(frozen=True, slots=True)
class OpenState:
    """An open state and what is in it.

    Attributes:
        memory: None where nothing has been learned.
        lost: the first and the last revision of each gap in the history that is known.
    """

    file: StateFile
    memory: dict[str, Any] | None
    lost: tuple[tuple[int, int], ...] = ()


def open_state(path: Path, own: Mapping[str, Any], changing: bool) -> OpenState:
    """Opens a state that agrees with `own`, its identity.

    Args:
        changing: the traced effects may change while it learns: then its memory says which they are.

    Raises:
        StateDamage: it is damaged, or it belongs to another vehicle, version or setting.
    """
    file = StateFile(path)
    try:
        kept, memory = file.identity(), file.memory()
        if not (memory is None or isinstance(memory, dict)):
            raise StateDamage("its memory has a wrong form")
        if changing and memory is not None:
            own = {**own, "effects": memory.get("effects")}
        lost = tuple((int(first), int(last)) for first, last in kept.get(LOST_KEY, ()))
        for name in own:
            if kept.get(name) != own[name]:
                raise StateDamage(f"it was learned with {name} {kept.get(name)}, and now {name} is {own[name]}")
    except BaseException:
        file.close()
        raise
    return OpenState(file, memory, lost)


def set_aside(path: Path) -> Path:
    """Renames a state and what SQLite keeps beside it, to the first name that is free."""
    number = 1
    while (aside := path.with_name(f"{path.stem}.refused-{number}.sqlite")).exists():
        number += 1
    _rename(path, aside)
    return aside


def bring_back(path: Path, own: Mapping[str, Any], changing: bool, but: frozenset[Path]) -> Path | None:
    """Puts the newest of the states that were set aside and fit in this place; gives the name that it had.

    Args:
        but: states that are known not to fit.
    """
    for earlier in sorted(path.parent.glob(f"{path.stem}.refused-*.sqlite"), key=_number, reverse=True):
        if earlier in but:
            continue
        try:
            open_state(earlier, own, changing).file.close()
        except (StateDamage, OSError, sqlite3.Error):
            continue
        _rename(earlier, path)
        return earlier
    return None


def has_lost_file(path: Path) -> bool:
    """Whether the file is gone while something beside it shows that it was there."""
    return not path.exists() and any(path.with_name(path.name + end).exists() for end in SIDE_FILE_ENDINGS)


def _number(path: Path) -> int:
    digits = path.stem.rpartition("-")[2]
    return int(digits) if digits.isdigit() and len(digits) < 10 else 0


def _rename(path: Path, to: Path) -> None:
    for end in (*SIDE_FILE_ENDINGS, ""):
        beside = path.with_name(path.name + end)
        if beside.exists():
            beside.rename(to.with_name(to.name + end))
