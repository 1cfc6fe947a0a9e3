"""The torque that drives a planned yaw rate: the model with its effects, solved for the command.

    a = (I₀ + ΔI) ṙ + b + d(r) + Σ θ_k φ_k,    τ = T⁻¹(a)

The moment a that the thrust must make follows from the plan; b is what a body's other velocities and its attitude take
of it. The stages of the actuators are undone from thrust to command. A delay is undone by sending the command earlier,
which only the sender can do.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Self

import numpy as np
from numpy.typing import NDArray

from incsvr.compensation.effects_in_force import FOLLOWED_BY_LEARNING, INERTIA, Compensation
from incsvr.errors import BadInput
from incsvr.model.efforts import Stage, lagged, root
from incsvr.model.structure import STAGES
from incsvr.numerics import Array
from incsvr.plant.axes import stream_of
from incsvr.plant.body import Coupled
from incsvr.plant.words import YAW_WORDS, AxisWords
from incsvr.signals.steps import refuse_steps
from incsvr.tracing.model import Effect, TracedModel, parts
from incsvr.tracing.vocabulary import WORDS

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
    usable, remarks = _usable(compensation, plan)
    model = replace(compensation.model, effects=usable)
    moment, parts = _moment(model, plan, inertial + body + damping)
    torque, taken, short = _command(model, plan, moment, words)
    ends = [torque, *(_command(model, plan, moment + side, words)[0] for side in (-half, half))]
    lead = max(model.theta.get(f"shift:{model.axis}", 0.0), 0.0)
    if lead > 0.0:
        short.append(f"send each {words.effort} {lead:.3g} s before its time: the thrust is so much later")
    return Feedforward(
        plan.time, torque, np.minimum.reduce(ends), np.maximum.reduce(ends), inertial, body, damping,
        parts | taken, lead, (*remarks, *short),
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


def _usable(compensation: Compensation, plan: Plan) -> tuple[tuple[Effect, ...], list[str]]:
    """The effects that a plan lets work out, and a sentence about each other one."""
    usable = []
    remarks = [
        f"{name} is left out: it refers to the clock of the traced recording"
        for name in compensation.left_out
        if name not in FOLLOWED_BY_LEARNING
    ]
    for effect in compensation.model.effects:
        own = replace(compensation, model=replace(compensation.model, effects=(effect,)))
        missing = sorted(set(own.channels) - plan.channels.keys())
        if missing:
            remarks.append(f"{effect.name} is left out: plan its {', '.join(missing)} too, in channels")
        else:
            usable.append(effect)
    return tuple(usable), remarks


def _moment(model: TracedModel, plan: Plan, rest: Array) -> tuple[Array, dict[str, Array]]:
    """(n,) the moment that the thrust must make [N m], of which `rest` is known, and what each effect takes of it."""
    of_inertia = {} if f"mass:{model.axis}" not in model.theta else {
        INERTIA: (model.whole_inertia - model.inertia) * plan.acceleration
    }  # fmt: skip
    acting = replace(model, effects=tuple(effect for effect in model.effects if effect.rows))
    signals = {
        name: plan.rate if name == model.axis else plan.channels[stream]
        for name, stream in Compensation(acting, ()).streams.items()
    }
    for effect in acting.effects:
        for row in effect.rows:
            if row.follows:
                share = plan.step / (effect.value("time", row.key) or plan.step)
                signals[f"~{row.key}"] = lagged(signals[row.follows], share)
    rest = rest + sum(of_inertia.values())
    needed, taken = rest, dict[str, Array]()
    for _ in range(INFLOW_ROUNDS):
        before = needed
        taken = parts(acting.effects, model.axis, signals, partial(_at_rest, needed))
        needed = np.asarray(rest + sum(taken.values()))
        if np.array_equal(before, needed):
            break
    return needed, of_inertia | {name: np.broadcast_to(each, plan.time.shape) for name, each in taken.items()}


def _ahead(value: Array, constant: float, time: Array) -> Array:
    """(n,) what a first-order lag with this time constant [s] makes the value of."""
    return value + constant * (np.gradient(value, time) if value.size > 1 else 0.0)


def _at_rest(needed: Array, stage: Stage) -> Array:
    """The moment that is needed: a stage that shapes the thrust is undone afterwards."""
    return needed


def _command(
    model: TracedModel, plan: Plan, moment: Array, words: AxisWords
) -> tuple[Array, dict[str, Array], list[str]]:
    """(n,) the command that makes a moment [N m], what each stage takes of it, and where one falls short.

    A lag is undone by lead, a curve by its map read backwards, a limit as far as it goes.
    """
    thrust, taken, remarks = moment, dict[str, Array](), list[str]()
    for kind in reversed(STAGES):
        for effect in model.effects:
            value = effect.value(kind, model.axis)
            if value is None:
                continue
            if kind == "lag":
                command = _ahead(thrust, value, plan.time)
            elif kind == "spin":
                speed = _ahead(root(thrust), value, plan.time)
                command = speed * np.abs(speed)
            else:
                stage = Stage(**{kind: value})
                command = stage.undone(thrust, model.top)
                lacking = np.abs(thrust - stage.static(command, model.top))
                where = lacking > SHORTFALL_SHARE * float(np.abs(moment).max())
                if where.any():
                    most = f"up to {float(lacking.max()):.3g} {words.effort_unit} of the planned {words.effort}"
                    reason = words.fill(WORDS[kind].sentence)
                    remarks.append(f"{plan_words(plan, where)}: {most} are beyond the thrusters: {reason}")
            taken[effect.name], thrust = taken.get(effect.name, 0.0) + command - thrust, command
    return thrust, taken, remarks
