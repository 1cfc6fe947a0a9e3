"""Every JSON that is written is valid: where there is no number in a result, or in a payload, there is null."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from service import wire
from service.wire.json_text import json_text

NO_NUMBERS = (math.nan, math.inf, -math.inf)


def strict(text: str | bytes) -> Any:
    """The value as a reader takes it that goes by RFC 8259."""

    def refuse(word: str) -> float:
        raise AssertionError(f"{word} is no JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.mark.parametrize("form", [each for each in vars(wire).values() if isinstance(each, type)], ids=str)
def test_what_is_no_number_in_any_field_of_any_payload_is_null(form: type) -> None:
    if not issubclass(form, wire.Form):
        pytest.skip("no payload")
    for field in form.model_fields:
        for number in NO_NUMBERS:
            for value, expected in (
                (number, None),
                ((1.0, number), [1.0, None]),
                ({"a": {"b": number}}, {"a": {"b": None}}),
            ):
                assert (
                    strict(form.model_construct(None, **{field: value}).model_dump_json(warnings=False))[field]
                    == expected
                )


def test_numbers_of_numpy_are_numbers() -> None:
    held = {"a": np.float32(0.5), "b": np.arange(2), "c": np.array([1.0, np.nan]), "d": [{"e": (math.inf, -math.inf)}]}
    assert strict(json_text(held)) == {"a": 0.5, "b": [0, 1], "c": [1.0, None], "d": [{"e": [None, None]}]}
