"""`python -m tests.docs.regenerate` writes what the program prints now into the pages that show it."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from tests.conftest import ROOT
from tests.docs.console import PAGES, printed


def main() -> None:
    for name in PAGES:
        page = ROOT / name
        with TemporaryDirectory() as folder:
            page.write_text(printed(page, Path(folder)), encoding="utf-8")


if __name__ == "__main__":
    main()
