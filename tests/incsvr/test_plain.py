"""Records as plain data and back."""

from __future__ import annotations

import json
from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from incsvr.numerics import Array
from incsvr.numerics.plain import from_plain, to_plain


@dataclass(frozen=True)
class Inner:
    level: float
    name: str = "none"


@dataclass(frozen=True)
class Outer:
    values: Array
    places: NDArray[np.intp]
    parts: tuple[Inner, ...]
    one: Inner | None = None
    further: Array = field(default_factory=lambda: np.empty(0))


def test_a_record_comes_back_to_the_bit_with_its_types() -> None:
    outer = Outer(np.array([0.1, 1e-300]), np.array([3, -4]), (Inner(1 / 3), Inner(2.0, "two")), Inner(5.0))
    back = from_plain(Outer, json.loads(json.dumps(to_plain(outer))))
    assert (back.parts, back.one) == (outer.parts, outer.one)
    assert back.values.tolist() == outer.values.tolist()
    assert back.values.dtype == np.float64
    assert back.places.dtype == np.intp


def test_what_an_earlier_form_lacks_or_lists_is_taken() -> None:
    back = from_plain(Outer, {"values": [], "places": [], "parts": [[1.5, "listed"]]})
    assert (back.parts, back.one, back.further.size) == ((Inner(1.5, "listed"),), None, 0)


@pytest.mark.parametrize("broken", [{"values": [], "places": []}, {"values": ["x"], "places": [], "parts": []}, [1.0]])
def test_what_is_no_such_record_is_refused(broken: object) -> None:
    with pytest.raises((TypeError, ValueError)):
        from_plain(Outer, broken)
