"""Records as plain data and back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.numerics.plain import UNLESS_EMPTY, from_plain, to_plain


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


@dataclass(frozen=True)
class Message:
    t: float | tuple[float, ...]
    kind: Literal["own", "other"] = "own"
    count: int = 0
    inner: Mapping[str, Inner] = field(default_factory=dict, metadata=UNLESS_EMPTY)


def test_what_is_empty_may_be_left_out() -> None:
    assert to_plain(Message((1.0, 2.0))) == {"t": [1.0, 2.0], "kind": "own", "count": 0}
    assert from_plain(Message, {"t": 3, "unknown": 1}) == Message(3.0)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ({}, "t: it is missing"),
        ({"t": [1.0, "x"]}, 't.1: give a finite number, not "x"'),
        ({"t": [1.0, None]}, "t.1: give a finite number, not null"),
        ({"t": 0.0, "kind": "none"}, 'kind: give one of own, other, not "none"'),
        ({"t": 0.0, "count": 1.5}, "count: give a whole number, not 1.5"),
        ({"t": 0.0, "count": True}, "count: give a whole number, not true"),
        ({"t": 0.0, "inner": {"a": {"level": float("inf")}}}, "inner.a.level: give a finite number, not Infinity"),
        ({"t": 0.0, "inner": []}, "inner: give an object of names and values"),
        (5, "give an object of names and values"),
    ],
)
def test_the_place_of_what_is_wrong_is_named(data: object, said: str) -> None:
    with pytest.raises(BadInput) as refusal:
        from_plain(Message, data)
    assert str(refusal.value) == said
