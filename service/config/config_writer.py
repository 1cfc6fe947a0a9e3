"""The configuration as people write it: YAML, each value with its meaning, its unit and its bounds."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from service.config.configuration import Config
from service.config.sources import defaults
from service.wire.json_text import json_text

HEAD = """\
# The whole configuration, with its defaults: Leng, the vehicle of the paper. Every line may be left out.
# A variable goes before the file (INCSVR_LEARNER__POLICY=paper), a flag before both (--set learner.policy=paper).
# `incsvr config check FILE` lists errors with their lines; `incsvr config show` prints the values in force.
"""


def commented_yaml(config: Config, head: str = HEAD, brief: bool = False) -> str:
    """The configuration as YAML, each value with its meaning, unit and bounds, below some lines that begin it.

    `brief` leaves out what is as it is by default, or by its preset, but the inertia: an inertia that nobody says is
    none.
    """
    by_preset = {
        name: of for name, of in defaults({"inputs": {"preset": config.inputs.preset}}).items() if name != "bus"
    }
    usual = Config(**by_preset) if brief else None
    return head + "\n".join(_section(config, config.model_dump(mode="json"), "", usual)) + "\n"


def _section(section: BaseModel, values: dict[str, Any], indent: str, usual: BaseModel | None) -> list[str]:
    lines = []
    for name, field in type(section).model_fields.items():
        value, default = getattr(section, name), None if usual is None else getattr(usual, name)
        if usual is not None and value == default and name not in ("vehicle", "inertia"):
            continue
        if name == "inertia" and getattr(section, "mass_matrix", None) is not None:
            continue  # it follows from the matrix, of each axis its own
        if isinstance(value, BaseModel):
            lines += ["", f"# {(type(value).__doc__ or '').partition(chr(10))[0]}", f"{name}:"]
            lines += _section(value, values[name], indent + "  ", default)
        else:
            lines.append(f"{indent}# {field.description}{_bounds(field.metadata)}")
            lines.append(f"{indent}{name}: {json_text(values[name])}")
    return lines


def _bounds(metadata: list[Any]) -> str:
    """The bounds of a value, in words."""
    words = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}
    found = [
        f"{word} {getattr(each, name):g}" for each in metadata for name, word in words.items() if hasattr(each, name)
    ]
    return f" ({', '.join(found)})" if found else ""
