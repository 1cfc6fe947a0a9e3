"""`python -m tests.docs.regenerate` writes what the program prints now into the pages that show it."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from tests.conftest import ROOT
from tests.docs.console import PAGES, printed
from tests.docs.lists import LISTS, generated


def main() -> None:
    for name in LISTS:
        page = ROOT / name
        page.write_text(generated(name, page.read_text(encoding="utf-8")), encoding="utf-8")
    for name in PAGES:
        page = ROOT / name
        with TemporaryDirectory() as folder:
            page.write_text(printed(page, Path(folder)), encoding="utf-8")


if __name__ == "__main__":
    main()
