"""The base of every section of the configuration, and the kinds of values."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationInfo,
    field_validator,
)

from incsvr.plant.mass_and_coriolis import mass_matrix


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
_CHUNK = r"(?!\.\.?(?:/|$))[A-Za-z0-9_.-]+"
Prefix = Annotated[
    str,
    Field(max_length=128),
    shaped(
        rf"{_CHUNK}(/{_CHUNK})*",
        "a prefix is names with slashes between them, such as leng/yaw; a name has letters from a to z, digits, _, . "
        "and - alone, and is neither . nor .., which lead out of the directory of the state",
    ),
]


def _by_commas(given: Any) -> Any:
    """A text with commas, as a shell takes it without quotes, as the list that it is."""
    return given.split(",") if isinstance(given, str) else given


def entries_of(given: Any) -> Any:
    """The entries of a matrix: of a text with commas, or of six rows of six."""
    rows = _by_commas(given)
    if not isinstance(rows, list | tuple):
        return rows
    whole = len(rows) == 6 and all(isinstance(row, list | tuple) and len(row) == 6 for row in rows)
    return [entry for row in rows for entry in row] if whole else rows


def _of_a_body(entries: tuple[float, ...]) -> tuple[float, ...]:
    mass_matrix(entries)
    return entries


MassMatrix = Annotated[tuple[float, ...], BeforeValidator(entries_of), AfterValidator(_of_a_body)]
Names = Annotated[tuple[Name, ...], BeforeValidator(_by_commas)]
Metres = Annotated[float, Field(ge=-100.0, le=100.0)]
Positive = Annotated[float, Field(gt=0.0, le=1e6)]
Seconds = Annotated[float, Field(gt=0.0, le=1e6)]


class Section(BaseModel):
    """A part of the configuration: unknown names are refused, because they are misspelt ones."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)

    @field_validator("*", mode="before")
    @classmethod
    def _is_spelt_as_its_kind(cls, given: Any, info: ValidationInfo) -> Any:
        """Refuses true, false and 350_0 where a number is meant: pydantic would read them as 1, 0 and 3500."""
        kinds = set(_kinds(cls.model_fields[info.field_name or ""].annotation))
        if any(_is_section(kind) for kind in kinds) or Any in kinds:
            return given
        if bool not in kinds and any(isinstance(each, bool) for each in _entries(given)):
            raise ValueError("give a number, a text or a list")
        if str not in kinds and kinds & {int, float}:
            for each in _entries(given):
                if isinstance(each, str) and "_" in each:
                    raise ValueError("write the digits of a number without _")
        return given


def _kinds(annotation: Any) -> Iterator[Any]:
    """A type and all that it is made of."""
    yield annotation
    for part in get_args(annotation):
        yield from _kinds(part)


def _is_section(kind: Any) -> bool:
    """Whether it judges its own values."""
    return isinstance(kind, type) and issubclass(kind, Section)


def _entries(given: Any) -> Iterator[Any]:
    """A value, or all that a list or a mapping holds at its ends."""
    if isinstance(given, Mapping):
        given = list(given.values())
    if not isinstance(given, list | tuple):
        yield given
        return
    for each in given:
        yield from _entries(each)
