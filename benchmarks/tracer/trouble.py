"""What goes wrong on real vehicles and in their logs, drawn anew for each seed: what `trace` says of it.

One vehicle, I = 24 kg m², d(r) = 9 r + 26 r|r| N m, |τ| ≤ 18 N m, eight minutes at 20 Hz under held commands; water
that lasts half a second. Kinds A are faults of clocks, thrusters and sensors that no effect of the catalogue describes:
right is a refusal, or a note or a span that says so, wrong is "nothing is missing". Kinds B have one effect: right is
its name, or a class that holds it, and nothing beside it.

    python -m benchmarks.tracer.trouble --seeds 10 --first-seed 850000
"""

from __future__ import annotations

import contextlib
import io
import json
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.study import CORES, Record, begin, in_processes, options, publish
from benchmarks.tables import counted, grouped, page, table
from incsvr.numerics import Array
from service.cli import command_line
from service.recordings.recording import Recording
from service.recordings.recording_csv import write

INERTIA, LINEAR, QUADRATIC, MAX_TORQUE_NM = 24.0, 9.0, 26.0, 18.0
"""I [kg m²], N_r [N m s/rad], N_r|r| [N m s²/rad²], largest torque [N m]."""
SAMPLE_PERIOD_S, SAMPLES, STEPS_PER_SAMPLE = 0.05, 9600, 5
"""Between two samples [s], samples, steps of the integration in a sample."""
GYRO_NOISE, TORQUE_NOISE, WATER_NM, WATER_LASTS_S = 0.002, 0.15, 0.3, 0.5
"""Deviations of the gyro [rad/s], the torque's sensor [N m] and the water [N m]; the water's correlation time [s]."""
TIME: Array = SAMPLE_PERIOD_S * np.arange(SAMPLES, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Fault:
    """What is done to the thrust (n,), given the command [N m], and to the streams that are logged."""

    thrust: Callable[[Array, np.random.Generator], Array] = lambda command, _: command
    logged: Callable[[Array, Array, np.random.Generator], tuple[Array, Array]] = lambda rate, torque, _: (rate, torque)
    stiffness: float = 0.0
    heading: float = 0.0
    """Sign of the heading that is logged; 0 where none is."""


def spells(random: np.random.Generator, count: int, seconds: float) -> NDArray[np.bool_]:
    """(n,) whether an instant lies in one of some spells that do not overlap."""
    begin = (np.sort(random.choice(int(TIME[-1] / (seconds + 10.0)), count, replace=False)) + 0.3) * (seconds + 10.0)
    inside: NDArray[np.bool_] = np.any((TIME[:, None] >= begin) & (TIME[:, None] < begin + seconds), axis=1)
    return inside


def parted(rate: Array, torque: Array, random: np.random.Generator) -> tuple[Array, Array]:
    """The torque's clock steps back by 0.6 to 1 s somewhere in the middle: its values come later from then on."""
    at, late = int(random.uniform(0.35, 0.65) * SAMPLES), round(random.uniform(0.6, 1.0) / SAMPLE_PERIOD_S)
    moved = torque.copy()
    moved[at + late :] = torque[at:-late]
    moved[at : at + late] = np.nan
    return rate, moved


def stuck(rate: Array, torque: Array, random: np.random.Generator) -> tuple[Array, Array]:
    """One value for half a minute."""
    at, lasts = int(random.uniform(0.2, 0.8) * SAMPLES), round(30.0 / SAMPLE_PERIOD_S)
    held = rate.copy()
    held[at : at + lasts] = rate[at]
    return held, torque


def late(random: np.random.Generator) -> NDArray[np.bool_]:
    """(n,) whether an instant lies after one near the middle."""
    return np.asarray(random.uniform(0.4, 0.6) * TIME[-1] < TIME)


KINDS: dict[str, tuple[str, Fault]] = {
    "clean": ("", Fault()),
    "A1 the torque's clock steps": ("", Fault(logged=parted)),
    "A2 thrusters off, three times 30 s": ("", Fault(thrust=lambda u, g: np.where(spells(g, 3, 30.0), 0.0, u))),
    "A3 half the thrust, fourteen times 8 s": ("", Fault(thrust=lambda u, g: np.where(spells(g, 14, 8.0), 0.5 * u, u))),
    "A4 a gyro that stands still for 30 s": ("", Fault(logged=stuck)),
    "B1 thrust goes with the square of the command": (
        "thrust_curve",
        Fault(thrust=lambda u, _: np.asarray(MAX_TORQUE_NM * np.sign(u) * (u / MAX_TORQUE_NM) ** 2)),
    ),
    "B2 thrust falls to 60 %": ("thrust_step", Fault(thrust=lambda u, g: np.where(late(g), 0.6 * u, u))),
    "B3 thrust fades by 28 %": ("thrust_drift", Fault(thrust=lambda u, _: u * (1.0 - 0.28 * TIME / TIME[-1]))),
    "B4 a gyro that reads 0.03 rad/s too much": ("gyro_bias", Fault(logged=lambda r, u, _: (r + 0.03, u))),
    "B6 a tether, the heading clockwise": ("tether", Fault(stiffness=0.35, heading=-1.0)),
}
"""By name: the effect that is right, and how it is made."""


def played(kind: str, seed: int) -> Recording:
    """One log; everything follows from the seed."""
    fault, random = KINDS[kind][1], np.random.default_rng([seed, 1])
    ends = np.cumsum(random.uniform(2.0, 10.0, 400))
    command: Array = random.uniform(-MAX_TORQUE_NM, MAX_TORQUE_NM, 400)[np.searchsorted(ends, TIME)]
    thrust = fault.thrust(command, random).tolist()
    kept, water, rate, heading = float(np.exp(-SAMPLE_PERIOD_S / WATER_LASTS_S)), 0.0, 0.0, 0.0
    rates, headings = np.empty(SAMPLES), np.empty(SAMPLES)
    for k in range(SAMPLES):
        rates[k], headings[k] = rate, heading
        water = kept * water + np.sqrt(1.0 - kept**2) * WATER_NM * random.normal()
        for _ in range(STEPS_PER_SAMPLE):
            moment = thrust[k] + water - fault.stiffness * heading - LINEAR * rate - QUADRATIC * rate * abs(rate)
            rate += SAMPLE_PERIOD_S / STEPS_PER_SAMPLE * moment / INERTIA
            heading += SAMPLE_PERIOD_S / STEPS_PER_SAMPLE * rate
    seen, torque = fault.logged(
        rates + random.normal(0.0, GYRO_NOISE, SAMPLES), command + random.normal(0.0, TORQUE_NOISE, SAMPLES), random
    )
    columns = {"yaw_rate": seen, "torque": torque}
    if fault.heading:
        columns["heading"] = fault.heading * headings + random.normal(0.0, 0.003, SAMPLES)
    return Recording("log.csv", TIME, columns)


def examine(case: tuple[str, int]) -> Record:
    """What `incsvr trace` says of one log."""
    kind, seed = case
    with tempfile.TemporaryDirectory() as folder:
        log, said = Path(folder) / "log.csv", Path(folder) / "trace.json"
        write(log, played(kind, seed))
        began, error = time.process_time(), io.StringIO()
        with contextlib.redirect_stderr(error), contextlib.redirect_stdout(io.StringIO()):
            status = command_line.main(["trace", str(log), "--inertia", str(INERTIA), "--json", str(said)])
        record: Record = {"kind": kind, "seed": seed, "seconds": time.process_time() - began}
        if status:
            record |= {"named": {}, "verdict": "refused", "said": [error.getvalue().strip()]}
        else:
            found = json.loads(said.read_text(encoding="utf-8"))
            # Notes that begin with the log's name are of its sensors; the others tell how it was traced.
            notes = [note for note in found["notes"] if note.startswith("log.csv")]
            record |= {
                "named": {each["effect"]: each["cannot_tell_from"] for each in found["effects"]},
                "verdict": found["verdict"],
                "said": notes + [f"{begin}–{end} s" for begin, end in found["spans"]],
            }
    return record | {"judged": judged(KINDS[kind][0], record)}


def judged(truth: str, record: Record) -> str:
    """right, class, said (refused, unexplained, or a note on the sensors), none, or false."""
    named: dict[str, list[str]] = record["named"]
    if len(named) == 1 and truth in named:
        return "right"
    if len(named) == 1 and truth in next(iter(named.values())):
        return "class"
    if record["said"] or record["verdict"] in ("refused", "unexplained"):
        return "said"
    return "false" if named else "none"


def report(document: Record) -> str:
    """Markdown."""
    verdicts, rows = ("right", "class", "said", "none", "false"), []
    for kind, records in grouped(document["records"], "kind").items():
        count = Counter(record["judged"] for record in records)
        named = counted(Counter(name for record in records for name in record["named"]))
        seconds = np.median([record["seconds"] for record in records])
        rows.append([kind, *(count[each] for each in verdicts), named, f"{seconds:.1f}"])
    return page(
        "# Trouble, drawn anew",
        f"Made by `{document['command']}` on {document['date']}, {document['processor']}, "
        f"seeds {document['first_seed']} to {document['first_seed'] + document['seeds'] - 1} for each kind.",
        "Right: the effect alone is named. Class: one effect is named whose class holds it. Said: refused, "
        "unexplained, or a note on the sensors. None: “nothing is missing”. False: other effects and no such word.",
        table(["kind", *verdicts, "named", "s"], rows),
    )


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.tracer.trouble",
        __doc__,
        seeds=(10, "logs of each kind"),
        first_seed=(850_000, "of them"),
        processes=(CORES, "logs at once"),
    )
    args, measured = begin(parser, words)
    cases = [(kind, args.first_seed + number) for kind in KINDS for number in range(args.seeds)]
    document = measured | {
        "seeds": args.seeds,
        "first_seed": args.first_seed,
        "records": in_processes(examine, cases, "logs", args.processes),
    }
    publish(args.out, "trouble", document, report(document))


if __name__ == "__main__":
    main()
