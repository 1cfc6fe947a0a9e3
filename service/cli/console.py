"""The console of rich: it draws in colours, and spells the control characters of the texts that others wrote."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

from rich.console import Console as RichConsole
from rich.console import ConsoleOptions, RenderableType
from rich.segment import Segment

from service.cli.terminal import behind, shown


class Console(RichConsole):
    """A console on standard output, or on standard error."""

    def __init__(self, *, stderr: bool = False, **more: Any) -> None:
        super().__init__(**{"file": behind(sys.stderr if stderr else sys.stdout), **more})

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterator[Segment]:
        for segment in super().render(renderable, options):
            yield segment if segment.control else Segment(shown(segment.text), segment.style)
