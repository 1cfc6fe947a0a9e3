"""What every section of the configuration is made of: its base, and the kinds of values."""

from __future__ import annotations

import re
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field

from incsvr.plant.inertia import mass_matrix


def shaped(pattern: str, sentence: str) -> AfterValidator:
    """A text that matches the whole pattern; a person who wrote another one is told the sentence."""

    def checked(text: str) -> str:
        if re.fullmatch(pattern, text) is None:
            raise ValueError(sentence)
        return text

    return AfterValidator(checked)


Endpoint = Annotated[
    str,
    shaped(
        r"(tcp|tls|quic|ws|unixsock-stream)/\S+",
        "write an endpoint as in tcp/127.0.0.1:7447; it begins with tcp/, tls/, quic/, ws/ or unixsock-stream/",
    ),
]
Name = Annotated[
    str,
    Field(max_length=64),
    shaped(r"[A-Za-z0-9_.-]+", "a name has letters without accents, digits, _, . and - alone"),
]
Prefix = Annotated[
    str,
    Field(max_length=128),
    shaped(
        r"[A-Za-z0-9_.-]+(/[A-Za-z0-9_.-]+)*",
        "a prefix is names with slashes between them, such as leng/yaw; a name has letters from a to z, digits, _, . "
        "and - alone",
    ),
]


def _row_by_row(given: Any) -> Any:
    """Six rows of six as the 36 entries that they are."""
    rows = given if isinstance(given, list | tuple) else ()
    whole = len(rows) > 0 and all(isinstance(row, list | tuple) for row in rows)
    return [entry for row in rows for entry in row] if whole else given


def _of_a_body(entries: tuple[float, ...]) -> tuple[float, ...]:
    mass_matrix(entries)
    return entries


MassMatrix = Annotated[tuple[float, ...], BeforeValidator(_row_by_row), AfterValidator(_of_a_body)]
Metres = Annotated[float, Field(ge=-100.0, le=100.0)]
Positive = Annotated[float, Field(gt=0.0, le=1e6)]
Seconds = Annotated[float, Field(gt=0.0, le=1e6)]


class Section(BaseModel):
    """A part of the configuration: unknown names are refused, because they are misspelt ones."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
