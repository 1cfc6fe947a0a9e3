"""One row of the table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Row:
    """What was tried, and what came of it.

    Attributes:
        what: was done.
        tried: how often.
        lost: what was published or sent and is gone, counted or said.
        wrong: answers that were not what was published, or a loss that nothing said.
        until: from the fault until it was over or said [s], of each try.
        remark: what the figures mean here.
    """

    what: str
    tried: int
    lost: int
    wrong: int
    until: Sequence[float]
    remark: str

    def as_text(self) -> str:
        """As a line of Markdown."""
        times = "—"
        if len(self.until):
            times = f"{np.median(self.until):.2f}, at most {max(self.until):.2f}"
        return f"| {self.what} | {self.tried} | {self.lost} | {self.wrong} | {times} | {self.remark} |"
