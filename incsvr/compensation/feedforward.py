"""The torque that drives a planned yaw rate: the model with its effects, solved for the command.

    a = (I₀ + ΔI) ṙ + b + f d(r) + Σ θ_k φ_k,    τ = T⁻¹(a)

The moment a that the thrust must make follows from the plan; b is what a body's other velocities and its attitude take
of it. The stages of the actuators are undone from thrust to command, each by the `command` of its class in the
catalogue: a lag by lead, a limit as far as it goes. A delay is undone by sending the command earlier, which only the
sender can do.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from incsvr.compensation.effects_in_force import HEADING_CHANNEL, HEADING_EFFECTS, Compensation
from incsvr.effects import Effect, Signals, Term, candidates
from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.plant.axes import stream_of
from incsvr.plant.body import Coupled
from incsvr.plant.words import YAW_WORDS, AxisWords
from incsvr.signals.steps import refuse_steps
from incsvr.tracing.of_model import drag_of

MAX_PLAN_STEP_S = 0.1
"""Step of a plan's grid at most [s]: rotors and water are slower."""
MAX_PLAN_STEPS = 20_000
"""Steps of a plan's grid at most."""
NORMAL_95_DEVIATIONS = 1.959964
"""Half an interval of 95 % in standard deviations."""
SHORTFALL_SHARE = 0.02
"""Part of the plan's largest moment from which it matters that a thrust falls short of what is needed."""
INFLOW_ROUNDS = 50
"""Rounds in which a moment that follows from the thrust, as of the inflow, and the thrust are made to agree."""


@dataclass(frozen=True, slots=True)
class Plan:
    """A planned motion on an even grid.

    Attributes:
        time, rate, acceleration: (n,) [s], [rad/s], [rad/s²], n ≥ 1.
        channels: further planned channels, (n,) each; `heading` [rad] among them where it is planned.
    """

    time: Array
    rate: Array
    acceleration: Array
    channels: Mapping[str, Array] = field(default_factory=dict)

    @classmethod
    def of(cls, time: Array, rate: Array, acceleration: Array | None, channels: Mapping[str, Array]) -> Self:
        """The plan between (m,) times [s] that increase, linear between two of them; m ≥ 1.

        Raises:
            BadInput: the times do not increase, or something is not given at each of them.
        """
        columns = {"rate": rate, **({} if acceleration is None else {"acceleration": acceleration}), **channels}
        for name, values in columns.items():
            if values.size != time.size:
                raise BadInput(f"t holds {time.size} times and {name} {values.size} values; give one for each")
        apart = np.diff(time)
        if not (apart > 0.0).all():
            raise BadInput("the times of a plan must increase from each to the next")
        refuse_steps(time, "the times of a plan")
        if acceleration is None:
            acceleration = np.gradient(rate, time) if time.size > 1 else np.zeros(1)
        span = float(time[-1] - time[0])
        step = min(float(apart.min(initial=np.inf)), MAX_PLAN_STEP_S)
        count = min(max(round(span / step), 1), MAX_PLAN_STEPS) + 1 if time.size > 1 else 1
        even = np.linspace(time[0], time[-1], count)
        on_grid = {name: np.interp(even, time, values) for name, values in channels.items()}
        return cls(even, np.interp(even, time, rate), np.interp(even, time, acceleration), on_grid)

    @property
    def step(self) -> float:
        """The step of the grid [s]."""
        return float(self.time[1] - self.time[0]) if self.time.size > 1 else 1.0


@dataclass(frozen=True, slots=True)
class Feedforward:
    """The torque that drives a plan, at its (n,) times.

    Attributes:
        time: (n,) [s].
        torque, low, high: (n,) the command, and its interval of 95 % [N m].
        inertia_part, body_part, damping_part: (n,) what the declared inertia, the body's other velocities with its
            attitude, and the damping take of it [N m].
        effects: what each effect takes of it, (n,) each; with the three above they add up to it.
        lead: by how much the command must be sent earlier [s].
        remarks: sentences about what the torque cannot do.
    """

    time: Array
    torque: Array
    low: Array
    high: Array
    inertia_part: Array
    body_part: Array
    damping_part: Array
    effects: Mapping[str, Array]
    lead: float
    remarks: tuple[str, ...]

    def at(self, time: Array) -> Feedforward:
        """The same at (m,) times within the plan [s]."""

        def there(values: Array) -> Array:
            return np.interp(time, self.time, values)

        return Feedforward(
            time, there(self.torque), there(self.low), there(self.high), there(self.inertia_part),
            there(self.body_part), there(self.damping_part),
            {name: there(each) for name, each in self.effects.items()}, self.lead, self.remarks,
        )  # fmt: skip


def feedforward(
    plan: Plan,
    damping: Array,
    sigma: Array,
    inertia: float,
    compensation: Compensation | None = None,
    words: AxisWords = YAW_WORDS,
    coupled: Coupled | None = None,
) -> Feedforward:
    """The torque that drives a plan.

    Args:
        plan: the motion.
        damping, sigma: (n,) of the learned model at the plan's rates, and the deviation of a sample there [N m].
        inertia: I₀, as declared [kg m²].
        compensation: the effects in force, of which the damping was freed.
        words: what remarks call the quantities of the axis.
        coupled: the axis in its body, whose velocities and angles the plan holds in its channels; None takes it by
            itself.
    """
    inertial = inertia * plan.acceleration
    body = np.zeros(plan.time.size) if coupled is None else _body_torque(coupled, plan)
    half = NORMAL_95_DEVIATIONS * sigma
    if compensation is None:
        moment = inertial + body + damping
        return Feedforward(plan.time, moment, moment - half, moment + half, inertial, body, damping, {}, 0.0, ())
    pairs, remarks = _usable(compensation, plan)
    seen = _signals(plan, compensation)
    moment, parts = _moment(pairs, plan, seen, inertial + body, damping)
    stages = sorted((pair for pair in pairs if pair[0].acts == "thrust"), key=lambda pair: -pair[0].stage)
    torque, taken, short = _command(stages, seen, moment, words)
    ends = [torque, *(_command(stages, seen, moment + side, words)[0] for side in (-half, half))]
    remarks += [f"{plan_words(plan, where)}: {sentence}" for sentence, where in short]
    if compensation.delay > 0.0:
        remarks.append(
            f"send each {words.effort} {compensation.delay:.3g} s before its time: the thrust is so much later"
        )
    return Feedforward(
        plan.time, torque, np.minimum.reduce(ends), np.maximum.reduce(ends), inertial, body, damping,
        parts | taken, max(compensation.delay, 0.0), tuple(remarks),
    )  # fmt: skip


def _body_torque(coupled: Coupled, plan: Plan) -> Array:
    """(n,) what a body's other velocities and its attitude take along a plan [N m]."""
    motion = {}
    for name in coupled.velocities:
        values = plan.channels[stream_of(coupled.axis, name)]
        motion[name] = values, np.gradient(values, plan.time) if values.size > 1 else np.zeros(1)
    parts = coupled.parts(plan.rate, motion, {name: plan.channels[name] for name in coupled.angles})
    return np.asarray(np.sum(list(parts.values()), axis=0))


def plan_words(plan: Plan, where: NDArray[np.bool_]) -> str:
    """The times (n,) at which a condition is met, in words."""
    times = plan.time[where]
    return f"from {times[0]:.4g} to {times[-1]:.4g} s" if times.size > 1 else f"at {times[0]:.4g} s"


def _usable(compensation: Compensation, plan: Plan) -> tuple[list[tuple[Effect, Term]], list[str]]:
    """The effects that a plan lets work out, and a sentence about each other one."""
    usable = []
    followed = {effect.name for effect in candidates() if effect.acts == "damping"}  # by the learned damping
    remarks = [
        f"{name} is left out: it refers to the clock of the traced recording"
        for name in compensation.left_out
        if name not in followed
    ]
    for effect, term in compensation.pairs():
        needed = {*effect.channels, *([HEADING_CHANNEL] if term.effect in HEADING_EFFECTS else [])}
        missing = sorted(needed - plan.channels.keys())
        if missing:
            remarks.append(f"{term.effect} is left out: plan its {', '.join(missing)} too, in channels")
        else:
            usable.append((effect, term))
    return usable, remarks


def _signals(plan: Plan, compensation: Compensation) -> Signals:
    model, count = compensation.model, plan.time.size
    return Signals(
        step=plan.step, start=np.array([0, count], dtype=np.intp), time=plan.time, rate=plan.rate,
        torque=np.zeros(count), channels=plan.channels, heading=plan.channels.get(HEADING_CHANNEL, np.zeros(count)),
        damping=model.damping_at(plan.rate), drag=drag_of(model), acceleration=plan.acceleration,
        applied=np.zeros(count), inertia=model.inertia, scale=model.scale, block=model.block, origin=model.origin,
    )  # fmt: skip


def _moment(
    pairs: list[tuple[Effect, Term]], plan: Plan, seen: Signals, inertial: Array, damping: Array
) -> tuple[Array, dict[str, Array]]:
    """(n,) the moment that the thrust must make [N m], and what each effect takes of it."""
    fixed: dict[str, Array] = {}
    scaled = damping
    for effect, term in pairs:
        if effect.acts == "inertia":
            fixed[term.effect] = term.coefficients[0] * plan.acceleration
        elif effect.acts == "damping":
            scaled, before = effect.factor(seen, term) * scaled, scaled
            fixed[term.effect] = scaled - before
    moments = [(effect, term) for effect, term in pairs if effect.acts in ("outside", "motion")]
    rest: Array = inertial + damping + sum(fixed.values())
    needed, parts = rest, dict[str, Array]()
    for _ in range(INFLOW_ROUNDS):
        here = replace(seen, applied=needed)
        parts = {
            term.effect: effect.columns(here, term.inner, term.coefficients) @ np.array(term.coefficients)
            for effect, term in moments
        }
        before, needed = needed, np.asarray(rest + sum(parts.values()))
        if np.array_equal(before, needed):
            break
    return needed, fixed | parts


def _command(
    stages: list[tuple[Effect, Term]], seen: Signals, moment: Array, words: AxisWords
) -> tuple[Array, dict[str, Array], list[tuple[str, NDArray[np.bool_]]]]:
    """(n,) the command that makes a moment [N m], what each stage takes of it, and where a stage falls short."""
    thrust, taken, short = moment, dict[str, Array](), list[tuple[str, NDArray[np.bool_]]]()
    for effect, term in stages:
        command = effect.command(thrust, seen, term)
        if not effect.lingers:
            lacking = np.abs(thrust - effect.thrust(command, seen, term))
            where = lacking > SHORTFALL_SHARE * float(np.abs(moment).max())
            if where.any():
                most = f"up to {float(lacking.max()):.3g} {words.effort_unit} of the planned {words.effort}"
                short.append((f"{most} are beyond the thrusters: {words.fill(effect.sentence)}", where))
        taken[term.effect], thrust = command - thrust, command
    return thrust, taken, short
