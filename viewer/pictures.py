"""`make pictures`: the pictures of the README, from a recording of the demo, by the real viewer."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from incsvr.errors import BadInput
from viewer.experiment import draw
from viewer.screen import Screen

ITERATIONS = (1, 5, 12, 15, 22)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m viewer.pictures", description=__doc__)
    parser.add_argument("recording", type=Path, help="a recording, such as out/leng.rrd of the demo")
    parser.add_argument("folder", type=Path, help="where the pictures go")
    args = parser.parse_args()
    try:
        pictures(args.recording, args.folder)
    except BadInput as error:
        print(f"pictures: {error}", file=sys.stderr)
        return 2
    return 0


def pictures(recording: Path, folder: Path) -> None:
    """One picture for each of ITERATIONS, one for each other page, and the experiment's runs (Fig. 4).

    Raises:
        BadInput: there is no such recording or iteration, or no Vulkan driver.
    """
    if not recording.is_file():
        raise BadInput(f"{recording}: there is no such recording; `make demo` makes one")
    with Screen(recording) as screen:
        for iteration in ITERATIONS:
            screen.show("Learning", iteration)
            _save(screen, folder / f"iteration-{iteration:02d}.png")
        for page in ("Before and after", "Signals", "Effects", "Health"):
            screen.show(page)
            _save(screen, folder / f"{page.lower().replace(' ', '-')}.png")
    draw(recording.parent, folder / "experiment.png")
    print(folder / "experiment.png")


def _save(screen: Screen, path: Path) -> None:
    screen.save(path)
    print(path)


if __name__ == "__main__":
    sys.exit(main())
