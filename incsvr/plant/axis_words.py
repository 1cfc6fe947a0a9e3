"""The sentences of the learning, in the words of the axis that is learned.

Excitation, resolution and offsets are judged without knowing the axis, and their sentences name yaw's quantities. Who
passes such a sentence on puts the axis's own in their place.
"""

from __future__ import annotations

from incsvr.plant.axes import Axis
from incsvr.plant.words import YAW_WORDS, words_of


def in_words_of(axis: Axis, text: str) -> str:
    """The sentence with the axis's velocity, force and unit in the place of yaw's."""
    words = words_of(axis)
    text = text.replace(YAW_WORDS.rate, words.rate).replace(YAW_WORDS.rate_unit, words.rate_unit)
    # with the space before it: signals.torque is a setting
    return text.replace(f" {YAW_WORDS.effort}", f" {words.effort}")
