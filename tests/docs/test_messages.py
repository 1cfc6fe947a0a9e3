"""Texts that a person reads name their subject and what happens: phrases that a newcomer read twice do not return."""

from __future__ import annotations

import re

from tests.docs.messages import texts

UNCLEAR = re.compile(
    r"\b(?:nothing|nobody|that) (?:says?|said|tells?|told)\b"
    r"|\bsay (?:which|what|where|so)\b"
    r"|\b(?:has|have|was|were|is|are) not (?:told|said)\b"
    r"|\b(?:told|tells?) (?:it |them )?(?:apart|from)\b"
    r"|\b(?:taken|takes) (?:for|up)\b"
    r"|\bstands? still\b"
    r"|\bbegan anew|begins anew|goes on\b"
    r"|\b(?:comes?|came) (?:yet|every|of)\b"
    r"|\b(?:left|let) (?:alone|over)\b"
    r"|\bforetold\b|\bheld against\b|\bgoes with\b|\bthe torque of now\b|\bhow it does\b"
)
"""Verbs without a subject, and verbs of all work (say, tell, take, stand, go, come) in place of the trade's."""


def test_no_text_has_a_phrase_that_was_read_twice() -> None:
    found = [f"{text.path}:{text.line}: {text.words}" for text in texts() if UNCLEAR.search(text.words)]
    assert not found, "\n".join(found)


def test_the_list_holds_the_texts_of_every_package() -> None:
    places = {text.path.partition("/")[0] for text in texts()}
    assert places == {"incsvr", "service", "simulator", "viewer"}
    assert UNCLEAR.search("nothing says where the yaw rate is")
    assert not UNCLEAR.search("the source of the yaw rate is not given")
