"""Builds the documentation site: the pages of docs/ and the API reference.

- The README is its home.
- Every file outside docs/ that a page links to becomes a page or a file of the site, and a link that leads nowhere ends
  the build; a module of incsvr leads to its place in the API reference.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINK = re.compile(r"(\]\(|src(?:set)?=\")([^)#\s:\"]+)((?:#[^)\s]*)?[)\"])")
ALWAYS_BUILT = tuple(ROOT / name for name in ("CHANGELOG.md", "CONTRIBUTING.md", "deploy/README.md"))
"""Pages of the navigation that no other page need lead to."""
PUBLIC = ("incsvr", "service.inputs", "service.logs", "service.wire")
"""Packages whose docstrings are the reference."""


def main() -> int:
    """Stages the pages, then lets the generator build them; its exit status, which is not 0 where a link is broken."""
    parser = argparse.ArgumentParser(description="Builds the documentation site.")
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "site", help="folder of the site (out/site)")
    parser.add_argument("--outline", action="store_true", help="the API reference by its headings alone: quicker")
    args = parser.parse_args()
    shutil.rmtree(args.out, ignore_errors=True)
    for uri, content in pages(args.outline).items():
        path = args.out / "pages" / uri
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    settings = (ROOT / "docs" / "site.yml").read_text(encoding="utf-8").replace("paths: []", f"paths: ['{ROOT}']")
    (args.out / "mkdocs.yml").write_text(settings, encoding="utf-8")
    command = [Path(sys.executable).parent / "zensical", "build", "--strict", "--config-file", "mkdocs.yml"]
    return subprocess.run(command, cwd=args.out, check=False).returncode


def pages(outline: bool = False) -> dict[str, bytes]:
    """Every file of the site by its place, before the generator makes HTML of it.

    Raises:
        SystemExit: a page links to something that is not there.
    """
    found = {uri: content.encode() for uri, content in reference(outline).items()}
    waiting = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *ALWAYS_BUILT]
    while waiting:
        path = waiting.pop()
        uri, _, anchor = place(path).partition("#")
        if anchor or uri in found:
            continue
        if path.suffix != ".md":
            found[uri] = path.read_bytes()
            continue
        text = path.read_text(encoding="utf-8")
        waiting += [target(path, link[2]) for link in LINK.finditer(text)]
        found[uri] = led(path, text).encode()
    return found


def led(page: Path, text: str) -> str:
    """The text of a page with its links led to where the site has what the repository has elsewhere."""
    start = Path(place(page)).parent

    def leading(found: re.Match[str]) -> str:
        uri, _, anchor = place(target(page, found[2])).partition("#")
        return f"{found[1]}{os.path.relpath(uri, start)}{f'#{anchor})' if anchor else found[3]}"

    return LINK.sub(leading, text)


def target(page: Path, link: str) -> Path:
    """The file that a link on a page leads to; of a folder, what describes it.

    Raises:
        SystemExit: there is none.
    """
    there = Path(os.path.normpath(page.parent / link))
    if there.is_dir():
        there = next((there / name for name in ("README.md", "__init__.py") if (there / name).is_file()), there)
    if not (there.is_file() and there.is_relative_to(ROOT)):
        raise SystemExit(f"{page.relative_to(ROOT)}: the link {link} leads nowhere")
    return there


def place(path: Path) -> str:
    """Where the site has a file of the repository, with the anchor of a module in the reference."""
    relative = path.relative_to(ROOT)
    if relative == Path("README.md"):
        return "index.md"
    if relative.parts[0] == "docs":
        return relative.relative_to("docs").as_posix()
    if path.suffix == ".py":
        module = dotted(path)
        for room, modules in rooms().items():
            if module in modules:
                return f"reference/{room}.md#{module}"
    return f"source/{relative.as_posix()}"


def rooms() -> dict[str, list[str]]:
    """The public modules by the package that holds them."""
    found: dict[str, list[str]] = defaultdict(list)
    for package in PUBLIC:
        folder = ROOT / package.replace(".", "/")
        for path in sorted(folder.rglob("*.py")):
            room = ".".join(path.parent.relative_to(ROOT).parts)
            found[room].append(dotted(path))
    return found


def dotted(path: Path) -> str:
    """The name of a module."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def reference(outline: bool = False) -> dict[str, str]:
    """The pages of the API reference by their place: one for each package, and one that lists them."""
    form = "## {0} {{#{0}}}" if outline else "::: {0}"
    pages, listed = {}, []
    for room, modules in rooms().items():
        pages[f"reference/{room}.md"] = f"# {room}\n\n" + "\n\n".join(form.format(module) for module in modules) + "\n"
        listed.append(f"- [{room}]({room}.md): {summary(room)}")
    head = (
        "# API reference\n\nFrom the docstrings. `incsvr` holds the mathematics: arrays in, arrays out, in SI units; "
        "equations are those of [the paper](../learner.md).\n\n"
    )
    return pages | {"reference/index.md": head + "\n".join(listed) + "\n"}


def summary(package: str) -> str:
    """The first line of a package's docstring."""
    text = (ROOT / package.replace(".", "/") / "__init__.py").read_text(encoding="utf-8")
    found = re.match(r'"""(.+?)(?:"""|\n)', text)
    return found[1] if found else ""


if __name__ == "__main__":
    sys.exit(main())
