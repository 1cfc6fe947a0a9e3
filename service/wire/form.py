"""The base of all payloads, and their writing and reading."""

from __future__ import annotations

from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, StrictFloat, ValidationError, model_validator

from incsvr.errors import BadInput
from service.wire.json_text import read_json

Numbers = tuple[StrictFloat, ...]


class Form(BaseModel):
    """A payload: finite numbers only, immutable, unknown fields ignored."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False, extra="ignore")


class WithNoise(Form):
    """A payload with the noise of a model; `sigma` is its copy for one release, and an earlier learner's name."""

    noise: float | None = None  # the samples' own deviation, over all rates [N m]
    sigma: float | None = Field(default=None, init=False)

    @model_validator(mode="before")
    @classmethod
    def _alike(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        return {**given, **dict.fromkeys(("noise", "sigma"), given.get("noise", given.get("sigma")))}


FormType = TypeVar("FormType", bound=Form)


def encode(form: Form) -> bytes:
    """The payload of `form`: UTF-8 JSON, floats to the last bit."""
    return form.model_dump_json().encode()


def decode(form: type[FormType], payload: bytes) -> FormType:
    """Reads a payload; BadInput says which field is wrong."""
    try:
        found = form.model_validate_json(payload)
        read_json(payload)  # refuses what stands twice
        return found
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"]) or "the payload"
        reason = first["msg"].removeprefix("Value error, ")
        raise BadInput(f"this is no {form.__name__}: {where}: {reason}") from error
    except ValueError as error:
        raise BadInput(f"this is no {form.__name__}: {error}") from None
