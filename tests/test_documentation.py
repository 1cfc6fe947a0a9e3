"""What the documentation says is so: examples run, links lead somewhere, command lines parse."""

from __future__ import annotations

import ast
import doctest
import importlib
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from pydantic import BaseModel

from service.cli.command_line import whole_parser
from service.cli.parser import Parser
from service.config.configuration import Config
from tests.conftest import ROOT

PAGES = sorted(
    path.relative_to(ROOT).as_posix()
    for path in (*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "deploy").rglob("*.md"))
)
WITH_EXAMPLES = sorted(
    path.relative_to(ROOT)
    for package in ("incsvr", "service", "simulator")
    for path in (ROOT / package).rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)
BLOCK = re.compile(r"^```\n(.*?)^```", re.DOTALL | re.MULTILINE)
SPAN = re.compile(r"`(incsvr [^`]+)`", re.DOTALL)


@pytest.fixture(scope="module")
def parser() -> Parser:
    """The command line's own, which takes whatever a placeholder stands for: names and flags are what is judged."""
    whole = whole_parser()
    waiting = [whole]
    while waiting:
        each = waiting.pop()
        waiting += each.commands.values()
        for action in each._actions:
            action.type = None
    return whole


@pytest.mark.parametrize("path", WITH_EXAMPLES, ids=str)
def test_the_examples_of_the_docstrings_run(path: Path) -> None:
    module = importlib.import_module(".".join(path.with_suffix("").parts).removesuffix(".__init__"))
    failed, tried = doctest.testmod(module)
    assert tried
    assert not failed


def lines_of(page: str) -> list[str]:
    """The command lines in the blocks of a page, without comments and what the shell does with the output."""
    blocks = BLOCK.findall((ROOT / page).read_text(encoding="utf-8"))
    lines = [line.strip() for block in blocks for line in block.replace("\\\n", " ").splitlines()]
    found = (re.match(r"(?:sudo )?(?:[A-Z_]+=\S+ )?(?:\S*/)?incsvr (?!/)(.*)", line) for line in lines)
    return [re.split(r" [>|] ", each[1].partition("  #")[0])[0] for each in found if each]


@pytest.mark.parametrize("page", [page for page in PAGES if lines_of(page)])
def test_every_command_line_of_a_page_parses(page: str, parser: Parser, capsys: pytest.CaptureFixture[str]) -> None:
    for line in lines_of(page):
        try:
            parser.parse_args(shlex.split(line, comments=True))
        except SystemExit as end:
            if end.code != 0:
                pytest.fail(f"{page}: incsvr {line}: {capsys.readouterr().err}")


@pytest.mark.parametrize("page", PAGES)
def test_every_command_that_a_sentence_names_is_there(page: str, parser: Parser) -> None:
    for span in SPAN.findall((ROOT / page).read_text(encoding="utf-8")):
        _, *words = span.split()
        if words[0].startswith("-"):
            assert words[0] in parser.flags, f"{page}: {span}"
            continue
        assert words[0] in parser.commands, f"{page}: {span}"
        command = parser.commands[words[0]]
        if command.commands and len(words) > 1:
            assert words[1] in command.commands, f"{page}: {span}"
            command = command.commands[words[1]]
        for flag in (word.partition("=")[0] for word in words if word.startswith("--")):
            assert flag in command.flags, f"{page}: {span}: there is no {flag}"


def test_a_wrong_command_line_is_noticed(parser: Parser) -> None:
    with pytest.raises(SystemExit):
        parser.parse_args(["fit", "run.csv", "--no-such-flag"])


@pytest.mark.parametrize("page", PAGES)
def test_the_python_of_a_page_names_what_is_there(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.ImportFrom) and node.module:
                module = importlib.import_module(node.module)
                assert all(hasattr(module, alias.name) for alias in node.names)


@pytest.mark.parametrize("page", [page for page in PAGES if "evidence" in page])
def test_a_page_of_evidence_names_its_command_and_date(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    assert re.search(r"\b20\d\d-\d\d-\d\d\b", text)
    assert re.search(r"`make \w+`|python -m benchmarks\.", text)


def test_the_site_is_built_without_a_broken_link(tmp_path: Path) -> None:
    """All pages but the text of the API reference, which `make docs` in CI builds as well."""
    pytest.importorskip("zensical", reason="the extra docs is not installed: pip install '.[docs]' in the checkout")
    built = subprocess.run(
        [sys.executable, ROOT / "docs" / "site.py", "--out", tmp_path, "--outline"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stdout + built.stderr
    html = tmp_path / "html"
    settings = (html / "configuration.html").read_text(encoding="utf-8")
    for name, field in Config.model_fields.items():
        assert f"<code>{name}" in settings
        section = type(field.default)
        for inner in section.model_fields if issubclass(section, BaseModel) else ():
            assert f"<code>{name}.{inner}</code>" in settings
    commands = (html / "commands.html").read_text(encoding="utf-8")
    assert all(f'id="{name}"' in commands for name in whole_parser().commands)
    assert (html / "pictures" / "before-and-after.png").is_file()


def test_a_broken_link_ends_the_build(tmp_path: Path) -> None:
    pytest.importorskip("zensical", reason="the extra docs is not installed: pip install '.[docs]' in the checkout")
    (tmp_path / "pages").mkdir()
    settings = (ROOT / "docs" / "site.yml").read_text(encoding="utf-8")
    (tmp_path / "mkdocs.yml").write_text(settings.partition("\nnav:")[0], encoding="utf-8")
    for text, status in (("[a](index.md#here)\n\n## Here\n", 0), ("[a](index.md#nowhere)\n", 1)):
        (tmp_path / "pages" / "index.md").write_text(f"# Home\n\n{text}")
        command = [str(Path(sys.executable).parent / "zensical"), "build", "--strict", "--config-file", "mkdocs.yml"]
        built = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert built.returncode == status, built.stdout + built.stderr
