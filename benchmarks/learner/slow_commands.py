"""The curve that `incsvr fit` learns where commands come slowly, and its remarks.

    python -m benchmarks.learner.slow_commands

A small vehicle under commands that hold for 0.8 to 2.4 s; its gyro comes at 20 Hz, the command's messages slower. Each
log is learned twice: as `fit` takes it by itself, and with the torque on a line between its messages, as it was before.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.study import begin, options, publish
from benchmarks.tables import page, table
from incsvr.signals.settings import MEASURED, TorqueKind
from service.commands.fit_alternatives import AS_GIVEN
from service.commands.fit_result import Fit
from service.recordings.recording import Recording
from service.recordings.recording_csv import RATE_LIMIT
from service.recordings.samples_from_recording import signals_for
from simulator import slow_commands

EVERY = (0.5, 0.2, 0.1, 0.05)
"""Between two messages of the command [s]."""
RATES = (0.5, 1.0, 1.5)
"""Where the curve is judged, on both sides [rad/s]."""
SAYS = "the damping curve may be"


def _row(every: float, seeds: range, torque: TorqueKind | None) -> list[str]:
    errors, said = [], 0
    for seed in seeds:
        off, says = examine(slow_commands.recording(seed, every), torque)
        errors.append(off)
        said += says
    each = np.abs(np.array(errors))  # seeds, rates, sides
    cells = [f"{np.median(each[:, k]):.0f} %, {each[:, k].max():.0f} %" for k in range(len(RATES))]
    named = "inferred from the data" if torque is None else torque
    return [f"{1.0 / every:g} Hz", named, *cells, f"{said} of {len(seeds)}"]


def examine(recording: Recording, torque: TorqueKind | None) -> tuple[list[list[float]], bool]:
    """The error at each of RATES on both sides [%], and whether a remark says that the curve may be off."""
    signals = signals_for([recording], slow_commands.INERTIA, RATE_LIMIT, torque)
    fit = Fit.of([recording], [], signals, None, {"policy": "paper"}, by_person=AS_GIVEN)
    both = np.array([[-rate, rate] for rate in RATES])
    served = fit.iterations[-1].model.predict(both.ravel()).damping.reshape(both.shape)
    off = 100.0 * (served / slow_commands.damping(both) - 1.0)
    return off.tolist(), any(SAYS in remark for remark in fit.remarks)


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.learner.slow_commands",
        __doc__,
        first_seed=(780_000, "of the logs"),
        seeds=(10, "logs of each kind"),
    )
    args, measured = begin(parser, words)
    seeds = range(args.first_seed, args.first_seed + args.seeds)
    rows = [_row(every, seeds, torque) for every in EVERY for torque in (None, MEASURED)]
    head = ["commands at", "torque", *(f"d(±{rate:g}): median, worst" for rate in RATES), "says that it is off"]
    text = page(
        "# The curve where commands come slowly",
        f"`{measured['command']}`, {measured['date']}. Seeds {seeds[0]}–{seeds[-1]}; error of the learned curve to the "
        "truth in % of it, over both sides and all seeds. *Told from the data* is `incsvr fit` by itself; *measured* "
        "takes the torque on a line between its messages, as it was before.",
        table(head, rows),
    )
    publish(args.out, "slow_commands", measured | {"rows": rows}, text)


if __name__ == "__main__":
    main()
