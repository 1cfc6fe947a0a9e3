"""`make pictures`: the pictures of the README, from a recording of the demo, by the real viewer."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from incsvr.errors import BadInput
from viewer import hull_picture
from viewer.pages import PAGES
from viewer.screen import Screen

ITERATIONS = (1, 15, 22)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m viewer.pictures", description=__doc__)
    parser.add_argument("recording", type=Path, help="a recording, such as out/leng.rrd of the demo")
    parser.add_argument("folder", type=Path, help="folder of the pictures")
    parser.add_argument("--page", choices=PAGES, help="this page alone, at the end of any recording")
    args = parser.parse_args()
    try:
        pictures(args.recording, args.folder, args.page)
    except BadInput as error:
        print(f"pictures: {error}", file=sys.stderr)
        return 2
    return 0


def pictures(recording: Path, folder: Path, page: str | None = None) -> None:
    """One picture for each of ITERATIONS, one for each other page, and what the hull adds; or of one page.

    Raises:
        BadInput: there is no such recording or iteration, or no Vulkan driver.
    """
    if not recording.is_file():
        raise BadInput(f"{recording}: there is no such recording; `make demo` makes one")
    with Screen(recording) as screen:
        if page is not None:
            screen.show(page)
            _save(screen, _named(folder, page))
            return
        for iteration in ITERATIONS:
            screen.show("Learning", iteration)
            _save(screen, folder / f"iteration-{iteration:02d}.png")
        for each in ("Before and after", "Signals", "Effects"):
            screen.show(each)
            _save(screen, _named(folder, each))
    hull_picture.draw(recording.parent, folder / "hull.png")
    print(folder / "hull.png")


def _named(folder: Path, page: str) -> Path:
    return folder / f"{page.lower().replace(' ', '-')}.png"


def _save(screen: Screen, path: Path) -> None:
    screen.save(path)
    print(path)


if __name__ == "__main__":
    sys.exit(main())
