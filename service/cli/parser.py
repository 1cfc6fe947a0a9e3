"""The parser of the command line: what is wrong is said in one sentence, with what was probably meant."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, NoReturn

from service.number import number_of, whole_number_of

LOG = "`incsvr inspect LOG --plot FILE` draws a log"
REMOVED: Mapping[tuple[str, str], str] = {
    ("demo", "--vehicle"): "name the vehicle of --log with --log-of",
    ("view", "--repair"): "a recording that was cut off opens as it is",
    ("page", "--archive"): "the files of `incsvr serve --archive DIR` are in DIR",
    ("page", "--identify"): "use `incsvr identify LOG --report FILE.html`",
    **{("view", flag): LOG for flag in ("--inertia", "--preset", "--column", "--system", "--axis", "--from", "--to")},
    ("keys", "--router"): "make the keys of each vehicle at its own listener, or write the access control of a shared "
    "router by Zenoh's documentation",
    ("compare", "--from-learner"): "compare the logs of the dives (`serve --archive` records them), or stored tables "
    "of dives",
    ("trace", "--manoeuvre"): "`next_manoeuvre` says what a log must show; write the efforts of a drive yourself, as a "
    "CSV file with the columns t and torque, and `incsvr simulate --vehicle FILE --commands FILE.csv` plays it",
    ("simulate", "--torque"): "write a vehicle file by `incsvr identify --write FILE`, and give --vehicle FILE "
    "--commands FILE.csv",
    **{
        ("simulate", flag): "write the run by --write DIR, change the file, and play it by `incsvr replay`"
        for flag in ("--drop-outs", "--jitter", "--duplicates")
    },
    **{(name, "--torque"): "give --set signals.torque=commanded or measured" for name in ("fit", "trace")},
    **{
        (name, "--mass-matrix"): "give --set vehicle.mass_matrix=M, or --vehicle FILE of `incsvr identify --write`"
        for name in ("fit", "trace", "identify")
    },
    ("compare", "--mass-matrix"): "give --set vehicle.mass_matrix=M",
    ("fit", "--smoothing"): "give --set signals.smoothing=S",
    ("fit", "--inputs"): "give --set learner.inputs=NAMES",
    ("incsvr", "inputs"): "use `incsvr inspect --bus`, with the same flags",
    ("export", "--link"): "replace base_link in the exported file",
    ("export", "--format uuv"): "take gazebo for gz-sim, or json and put its figures into a <hydrodynamic_model>",
    ("export", "--format python-vehicle-simulator"): "take python, and call its acceleration in the dynamics of your "
    "vehicle",
}
"""By command, and flag or flag and value; by the program, and command."""


NUMBERS = {"int": "a whole number", "float": "a number"}
"""Words for the value of a flag, by the name of its argparse type."""


class _Once(argparse.Action):
    """A flag that has one value: given again, argparse would keep the last one and say nothing."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        if option_string is not None and self.dest in parser.given:
            many = ", with all its values behind it" if self.nargs in ("+", "*") else ""
            raise argparse.ArgumentError(self, f"it is given twice; give it once{many}")
        parser.given.add(self.dest)
        super().__call__(parser, namespace, values, option_string)


class _Store(_Once, argparse._StoreAction):
    pass


class _StoreTrue(_Once, argparse._StoreTrueAction):
    pass


class Parser(argparse.ArgumentParser):
    """A parser whose refusals are single sentences; its help ends with an example.

    Parsers of sub-commands are of this class as well.
    """

    def __init__(self, *args: Any, example: str = "", **more: Any) -> None:
        self.example = example
        if example:
            more |= {"epilog": f"example:\n  {example}", "formatter_class": argparse.RawDescriptionHelpFormatter}
        super().__init__(*args, **more)
        for kind, read in ((float, number_of), (int, whole_number_of)):
            self.register("type", kind, read)
        for name, action in (("store", _Store), ("store_true", _StoreTrue)):
            self.register("action", name, action)
        self.register("action", None, _Store)

    @property
    def flags(self) -> list[str]:
        """Every flag, in its long form where it has one."""
        return [flag for action in self._actions for flag in action.option_strings]

    @property
    def commands(self) -> dict[str, Parser]:
        """The parsers of its sub-commands, by name."""
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                return dict(action.choices)
        return {}

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parses as argparse does; the parser that knows the flags refuses the remainder."""
        self.given: set[str] = set()
        for word in args or ():
            if sentence := self._removed(word.partition("=")[0]):
                self.error(sentence)
        found, left = super().parse_known_args(args, namespace)
        if left:
            flag = next((word for word in left if word.startswith("-")), None)
            self.error(f"unexpected argument {left[0]!r}" if flag is None else self._no_flag(flag.partition("=")[0]))
        return found, left

    def error(self, message: str) -> NoReturn:
        """Ends the program with status 2 and one sentence that names the cure."""
        self.exit(2, f"{self.prog}: {self._sentence(message)}\n")

    @property
    def _all(self) -> str:
        return f"; `{self.prog} --help` lists all"

    def _removed(self, flag: str) -> str | None:
        """The sentence on a flag, or a flag and its value, that left."""
        instead = REMOVED.get((self.prog.rpartition(" ")[2], flag))
        return instead and f"{flag} was removed; {instead}"

    def _no_flag(self, flag: str) -> str:
        return f"there is no flag {flag}{meant(flag, self.flags) or self._all}"

    def _sentence(self, message: str) -> str:
        if found := re.fullmatch(r"the following arguments are required: (.*)", message):
            example = f", as in `{self.example}`" if self.example else f"; `{self.prog} --help` lists all"
            return f"{found[1]} is missing{example}"
        where, _, what = message.removeprefix("argument ").partition(": ")
        where = where.rpartition("/")[2]
        if found := re.fullmatch(r"invalid choice: '?(.*?)'?[ ,].*\(choose from (.*)\)", what):
            choices = [choice.strip(" '") for choice in found[2].split(",")]
            if sentence := self._removed(f"{where} {found[1]}".removeprefix("COMMAND ")):
                return sentence
            if where in ("COMMAND", "ACTION"):
                return f"there is no command {found[1]}{meant(found[1], choices) or self._all}"
            return f"{where} takes {one_of(choices)}, not {found[1]}{meant(found[1], choices)}"
        if found := re.fullmatch(r"invalid (\w+) value: '(.*)'", what):
            return f"{where} takes {NUMBERS.get(found[1], 'another value')}, not {found[2]}"
        if what.startswith("expected "):
            return f"{where} needs a value: {what}"
        return f"{where}: {what}" if what else message


def meant(word: str, known: Iterable[str]) -> str:
    """`; did you mean …?` where one of the known words is close, else nothing.

    >>> meant("trcae", ["fit", "trace"])
    '; did you mean trace?'
    >>> meant("x", ["fit", "trace"])
    ''
    """
    close = get_close_matches(word, list(known), n=1, cutoff=0.6)
    return f"; did you mean {close[0]}?" if close else ""


def one_of(choices: Sequence[str]) -> str:
    """The choices in a sentence.

    >>> one_of(["blueos", "ros2", "px4"])
    'blueos, ros2 or px4'
    """
    *most, last = choices
    return f"{', '.join(most)} or {last}" if most else last
