"""The base of all payloads, and their writing and reading."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

from incsvr.errors import BadInput
from incsvr.numerics.plain import from_plain, to_plain
from service.wire.json_text import json_text, read_json

Numbers = tuple[float, ...]


class Form:
    """A payload, a frozen dataclass: finite numbers only; fields that a reader does not know are ignored."""


@dataclass(frozen=True, kw_only=True)
class WithNoise(Form):
    """A payload with the noise of a model; `sigma` is its copy for one release, and an earlier learner's name."""

    noise: float | None = None  # the samples' own deviation, over all rates [N m]
    sigma: float | None = None

    def __post_init__(self) -> None:
        noise = self.sigma if self.noise is None else self.noise
        for name in ("noise", "sigma"):
            object.__setattr__(self, name, noise)


FormType = TypeVar("FormType", bound=Form)


def encode(form: Form) -> bytes:
    """The payload of `form`: UTF-8 JSON, floats to the last bit."""
    return json_text(to_plain(form), compact=True).encode()


def decode(form: type[FormType], payload: bytes) -> FormType:
    """Reads a payload; BadInput says which field is wrong."""
    try:
        found = read_json(payload)
        if not isinstance(found, dict):
            raise ValueError('the payload: write an object, such as {"name": value}')
        return from_plain(form, found)
    except (ValueError, TypeError, KeyError, AttributeError, IndexError) as error:
        # No name is bound to the error here: with its frames it would hold the query, which ends when it is dropped.
        why = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise BadInput(f"this is no {form.__name__}: {why}") from error
