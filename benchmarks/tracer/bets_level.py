"""How often bets on an effect that is not there are won, over hours of ordinary missions with nothing hidden.

`make bets-level`. A tracer that suspects falsely is played by chance: in each quiet hour every effect that may come on
under way is fitted to ten minutes, however little it explains, and bet on from then on as live tracing does it: half a
window at a time, fitted anew before each, the bets going on from what was won, to the end of the hour. An effect counts
as won where the bets ever reach 1/α. Where the first model is right, that happens in at most α of the hours (bets.py).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from itertools import chain

import numpy as np

from benchmarks.study import Record, begin, in_processes, options, publish
from benchmarks.tables import grouped, interval, page, table
from benchmarks.tracer.live_missions import EFFECTS, HOUR_S, between, configured, drawn
from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.fresh_data import COMMANDED_TORQUE, as_run, compare_on_fresh_data
from incsvr.errors import BadInput
from incsvr.tracing import innovations
from incsvr.tracing.candidates import admissible, every_lead
from incsvr.tracing.fit import fit
from incsvr.tracing.model import model_of
from service.config.configuration import Config
from service.recordings.recording import Streams
from simulator.missions import play

WINDOW_S, TRIAL_S = 600.0, 300.0
"""What a trace sees, and how much is bet on before effects are fitted anew [s]: as in `live_missions`."""
LEVELS = (0.05, 0.01, 0.001)


def examine(seed: int) -> list[Record]:
    """One quiet hour: of each effect the most that bets on it ever won, as ln W."""
    mission = drawn(seed, False)
    outcome = play(mission)
    config, streams = configured(mission, "off"), outcome.recording.streams()
    records = []
    for name in EFFECTS:
        began = time.process_time()
        try:
            won, trials = _bet(name, streams, config)
            found: Record = {"won": won, "trials": trials}
        except BadInput as error:
            found = {"why": str(error)}
        about = {"seed": seed, "kind": mission.kind, "vehicle": mission.vehicle, "effect": name}
        records.append(about | found | {"seconds": round(time.process_time() - began, 1)})
    return records


def _bet(name: str, streams: Streams, config: Config) -> tuple[float, int]:
    most, earlier, trials = 0.0, 0.0, 0
    for fresh in np.arange(WINDOW_S, HOUR_S - TRIAL_S + 1.0, TRIAL_S).tolist():
        effects = _fitted(name, between(streams, fresh - WINDOW_S, fresh), config)
        data = between(streams, fresh - TRIAL_S, fresh + TRIAL_S)
        found = compare_on_fresh_data(data, fresh, config.signal_settings(), config.learner_settings(), None, effects)
        if not found.turned:
            continue
        trials += 1
        most = max(most, earlier + found.evidence)
        earlier += found.won
    return most, trials


def _fitted(name: str, streams: Streams, config: Config) -> Compensation:
    """The effect as it explains these data best."""
    problem = innovations.pose([as_run(streams)], config.vehicle.inertia, [], COMMANDED_TORQUE)
    base = fit(problem, problem.start, problem.colour)
    effects = [effect for effect in admissible([], problem.cells) if effect.name == name]
    alone = [lead for lead in every_lead(problem, base, effects) if len(lead.parts) == 1]
    if not alone:
        raise BadInput(f"these data do not hold what shows {name}")
    best = max(alone, key=lambda lead: lead.gain)
    fitted = fit(problem, base.hypothesis.with_part(best.part), base.colour)
    return Compensation.of(model_of(problem, fitted, 0.0))


def report(document: Record) -> str:
    """Markdown."""
    records: Sequence[Record] = document["records"]
    played = [each for each in records if each.get("trials")]
    rows = []
    for name in (*EFFECTS, "all"):
        won = [each["won"] for each in played if name in (each["effect"], "all")]
        rows.append([name, len(won), *(_share(won, level) for level in LEVELS)])
    hours = len(grouped(records, "seed"))
    return page(
        "# How often bets on effects that are not there are won",
        f"Made by `{document['command']}`, {document['date']}: {hours} quiet hours of ordinary missions, seeds "
        f"{document['first_seed']}…, each effect fitted to ten minutes and bet on for the rest of the hour, five "
        f"minutes at a time. {len(records) - len(played)} of {len(records)} pairs of hour and effect held too "
        "little motion to bet. The share of pairs in which the bets ever reached 1/α, with its 95 % interval:",
        table(["effect", "pairs", *(f"α = {level:g}" for level in LEVELS)], rows),
    )


def _share(won: Sequence[float], level: float) -> str:
    hits = sum(each >= -np.log(level) for each in won)
    low, high = interval(hits, len(won))
    return f"{hits} ({100.0 * low:.0f}–{100.0 * high:.0f} %)"


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.tracer.bets_level",
        __doc__,
        first_seed=(940_000, "of the hours"),
        hours=(40, "quiet hours"),
        minutes=(float("inf"), "after which no hour is begun"),
        processes=(2, "hours at once"),
    )
    args, measured = begin(parser, words)
    seeds = range(args.first_seed, args.first_seed + args.hours)
    records = chain.from_iterable(in_processes(examine, seeds, "hours", args.processes, args.minutes))
    document = measured | {"first_seed": args.first_seed, "records": list(records)}
    publish(args.out, "bets_level", document, report(document))


if __name__ == "__main__":
    main()
