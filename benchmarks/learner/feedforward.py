"""Yaw control with and without the feed-forward torque: by how much it lowers the tracking error.

An AUV of the simulated missions is driven in open loop for ten minutes and traced; the learner learns the same run,
freed of what was found. A PI rate controller, tuned as that of the missions, then follows a smooth plan of the yaw
rate in moving water, once alone and once with the torque that the learner gives for the plan. Nothing else differs.
The hull comes on between two runs, and the learner follows it by itself.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from benchmarks.study import Record, begin, in_processes, options, publish, revision
from benchmarks.tables import grouped, page, table
from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.feedforward import Plan as PlannedMotion
from incsvr.compensation.feedforward import feedforward
from incsvr.compensation.fresh_data import as_run
from incsvr.numerics import Array, root_mean_square
from incsvr.tracing import trace
from service.recordings.recording import Recording, from_streams, sequence
from service.recordings.recording_csv import RATE_LIMIT
from service.recordings.samples_from_recording import learn, learner_for, samples_of, signals_for
from simulator.effects import Circumstances, Physics
from simulator.missions.hidden import DRAG_GROWTH, hide
from simulator.missions.mission import COMPASS_NOISE, GYRO_NOISE, WATER
from simulator.missions.motion import Motion, sail
from simulator.missions.plans import Plan
from simulator.missions.vehicles import VEHICLES, Vehicle
from simulator.noise import lasting_noise
from simulator.trial_command import command
from simulator.trial_vehicle import STEP

CASES = (
    "nothing", "hull", "dead_zone", "torque_asymmetry", "torque_saturation", "torque_lag", "torque_delay",
    "bias_torque", "inertia", "inflow", "coulomb", "memory",
)  # fmt: skip
"""What the vehicle has that its declaration lacks; each effect can be inverted."""
BEAT_STEPS = round(0.1 / STEP)
"""Integration steps of a controller's beat: 10 Hz."""
BEAT_S = BEAT_STEPS * STEP
EXCITATION_S, CONTROL_S, SETTLE_S = 600.0, 300.0, 10.0
"""Lengths of the runs, and the beginning of the second that is not judged [s]."""
PLAN_RATE_SHARE, PLAN_HOLD_S = 0.45, (8.0, 20.0)
"""Largest planned rate in the vehicle's full one, and how long a set point is held [s]."""
WATER_TIME_S = 2.0
"""Correlation time of the water's moment [s]."""


def examine(case: tuple[str, int]) -> Record:
    """One vehicle that a seed draws, with what the case names."""
    name, seed = case
    vehicle = VEHICLES["auv"]
    for_effect, for_drive, for_plan, for_control = (
        np.random.default_rng(each) for each in np.random.SeedSequence([seed, *name.encode()]).spawn(4)
    )
    sound = Physics(vehicle.scale.inertia, vehicle.drag)
    physics = sound
    if name == "hull":
        physics = replace(sound, drag=lambda rate: (1.0 + DRAG_GROWTH) * vehicle.drag(rate))
    elif name != "nothing":
        ticks = np.arange(2 * round(EXCITATION_S / STEP) + 1, dtype=np.float64) * STEP / 2.0
        physics, _ = hide(name, sound, vehicle, Circumstances(vehicle.scale, 1.0, for_effect, ticks))
    runs = [_driven(each, vehicle, for_drive) for each in ((sound, physics) if name == "hull" else (physics,))]
    found = trace([as_run(runs[-1].streams())], inertia=vehicle.scale.inertia) if name != "hull" else None
    effects = [] if found is None else [each.effect for each in found.effects]
    compensation = Compensation.of(found.model) if found is not None and found.effects else None
    wish = _wish(vehicle, for_plan)
    plain = _ahead(sequence(runs), vehicle, None, wish)
    ahead = plain if compensation is None else _ahead(sequence(runs), vehicle, compensation, wish)
    chance = int(for_control.integers(2**32))
    alone, declared, helped = (_error(physics, vehicle, wish, each, chance) for each in (None, plain, ahead))
    errors = {"alone": alone, "declared": declared, "with": helped, "ratio": helped / alone}
    return {"case": name, "seed": seed, "found": effects} | errors


def _driven(physics: Physics, vehicle: Vehicle, random: np.random.Generator) -> Recording:
    """A run in open loop up to full torque: held levels, then several sines at once."""
    beats: Array = BEAT_S * np.arange(round(EXCITATION_S / BEAT_S), dtype=np.float64)
    levels, sines = (np.array(command(k, vehicle.scale, beats, random).table) for k in ("telegraph", "multisine"))
    asked = Plan("torque", np.where(beats < 0.5 * EXCITATION_S, levels, sines).tolist())
    motion = _sailed(physics, vehicle, asked, random)
    return from_streams("driven", {"yaw_rate": (beats, motion.gyro), "torque": (beats, motion.command)})


def _sailed(physics: Physics, vehicle: Vehicle, asked: Plan, random: np.random.Generator) -> Motion:
    beats = len(asked.wish)
    steps = beats * BEAT_STEPS
    kept = math.exp(-STEP / WATER_TIME_S)
    kicks = math.sqrt(1.0 - kept**2) * random.standard_normal(steps)
    water = vehicle.scale.torque * random.uniform(*WATER) * lasting_noise(random.standard_normal(), kept, kicks)
    noise = (GYRO_NOISE * random.standard_normal(beats), COMPASS_NOISE * random.standard_normal(beats))
    return sail(physics, vehicle, asked, BEAT_STEPS, water, noise)


def _wish(vehicle: Vehicle, random: np.random.Generator) -> Array:
    """(beats,) a planned rate [rad/s]: set points, rounded off as a vehicle can follow them."""
    beats = round(CONTROL_S / BEAT_S)
    ends = np.cumsum(random.uniform(*PLAN_HOLD_S, beats))
    spell = np.searchsorted(ends, BEAT_S * np.arange(beats), side="right")
    points = PLAN_RATE_SHARE * vehicle.scale.rate * random.uniform(-1.0, 1.0, spell[-1] + 1)
    kept = math.exp(-BEAT_S * vehicle.bandwidth)
    smooth: Array = points[spell]
    for _ in range(2):
        smooth = lasting_noise(0.0, kept, (1.0 - kept) * smooth)
    return smooth


def _ahead(run: Recording, vehicle: Vehicle, compensation: Compensation | None, wish: Array) -> Array:
    """(beats,) the torque that the learner gives for the plan after this run, sent as early as it says [N m]."""
    inertia = vehicle.scale.inertia
    signals = signals_for([run], inertia, RATE_LIMIT)
    samples, _ = samples_of(run, signals, compensation)
    *_, last = learn(samples, learner_for(samples))
    beats: Array = BEAT_S * np.arange(wish.size, dtype=np.float64)
    plan = PlannedMotion.of(beats, wish, None, {})
    said = last.model.predict(plan.rate)
    found = feedforward(plan, said.damping, said.sigma, inertia, compensation)
    return np.interp(beats + found.lead, found.time, found.torque)


def _error(physics: Physics, vehicle: Vehicle, wish: Array, ahead: Array | None, seed: int) -> float:
    """The root mean square of true rate less planned rate under control [rad/s]."""
    proportional = 2.0 * vehicle.scale.inertia * vehicle.bandwidth
    integral = 0.5 * vehicle.bandwidth * proportional
    asked = Plan("rate", wish.tolist(), proportional, 0.0, integral, ahead=() if ahead is None else ahead.tolist())
    motion = _sailed(physics, vehicle, asked, np.random.default_rng(seed))
    error = motion.yaw_rate[::BEAT_STEPS] - wish
    return root_mean_square(error[round(SETTLE_S / BEAT_S) :])


def report(document: Record) -> str:
    """Markdown."""
    rows = []
    for name, records in grouped(document["records"], "case").items():
        ratios = [each["ratio"] for each in records]
        keys = ("alone", "declared", "with")
        medians = (f"{1e3 * float(np.median([each[key] for each in records])):.1f}" for key in keys)
        found = ", ".join(sorted({effect for each in records for effect in each["found"]})) or "–"
        half = f"{sum(ratio <= 0.5 for ratio in ratios)} of {len(ratios)}"
        rows.append([name, *medians, f"{np.median(ratios):.2f}", f"{max(ratios):.2f}", half, found])
    head = [
        "the vehicle has",
        "PI alone [mrad/s]",
        "no effects",
        "feed-forward",
        "ratio",
        "worst",
        "at most half",
        "traced",
    ]
    return page(
        "# Yaw control with the feed-forward torque",
        f"Made by `{document['command']}` on {document['date']}, revision {document['revision']}.",
        " ".join(__doc__.split("\n\n")[1].split()),
        "RMS tracking errors are medians over the seeds. *No effects* is the feed-forward of a learner that knows of "
        "none. A ratio is the error with the feed-forward over that of the PI alone, of one seed.",
        table(head, rows),
    )


def main(words: list[str] | None = None) -> int:
    parser = options(
        "benchmarks.learner.feedforward", __doc__,
        seeds=(5, "vehicles of each case"), first_seed=(3_510_000, "first seed"), processes=(1, "processes"),
    )  # fmt: skip
    given, document = begin(parser, words)
    cases = [(name, given.first_seed + k) for name in CASES for k in range(given.seeds)]
    records = in_processes(examine, cases, "yaw control", given.processes)
    document |= {"revision": revision(), "records": records}
    publish(given.out, "feedforward", document, report(document))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
