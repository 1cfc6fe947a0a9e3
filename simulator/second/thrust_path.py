"""Effects between the command and the thrust: rotors, buses, gear, supply, flow past the propeller."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

from simulator.second.plant import STEP, Parameters, Plant, Setting, Stage


def torque_lag(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """The motor's lag before the propeller's, or a rotor that a given shaft torque drives against its quadratic load.

    The second is slow where it turns slowly: J ṅ = Q − k n|n| has the time constant J/(2 k n). The parameter is the
    mean delay of the first, and the time constant of the second at a quarter of the full thrust, half of its speed.
    """
    constant = here.size * here.time_scale * here.between(0.15, 0.28)
    full = here.full_torque

    def two_in_series() -> Stage:
        motor, propeller = 0.0, 0.0
        motor_gain = -math.expm1(-STEP / (0.4 * constant))
        propeller_gain = -math.expm1(-STEP / (0.6 * constant))

        def stage(command: float) -> float:
            nonlocal motor, propeller
            before = propeller
            motor += motor_gain * (command - motor)
            propeller += propeller_gain * (motor - propeller)
            return 0.5 * (before + propeller)

        return stage

    def loaded_rotor() -> Stage:
        speed = 0.0
        rate = STEP / constant

        def stage(command: float) -> float:
            nonlocal speed
            before = speed
            # Implicit in the load, since a fast small rotor at full load would overshoot in an explicit step.
            speed = (speed + rate * command / full) / (1.0 + rate * abs(speed))
            return 0.5 * full * (before * abs(before) + speed * abs(speed))

        return stage

    rotor = here.heads()
    stages = (*plant.stages, loaded_rotor if rotor else two_in_series)
    shape = "loaded rotor" if rotor else "two in series"
    return replace(plant, stages=stages), {"time_constant_s": constant, "shape": shape}


def torque_delay(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """A shared bus: each command waits for its turn, now shorter, now longer, but none overtakes another."""
    mean = here.size * here.time_scale * here.between(0.12, 0.25)
    waits = (mean * here.random.uniform(0.8, 1.2, here.time.size) / STEP).round().astype(int).tolist()

    def shared_bus() -> Stage:
        waiting: deque[tuple[int, float]] = deque()
        step, last, in_force = 0, 0.0, 0.0

        def stage(command: float) -> float:
            nonlocal step, last, in_force
            if command != last:
                due = step + waits[step]
                waiting.append((max(due, waiting[-1][0]) if waiting else due, command))
                last = command
            while waiting and waiting[0][0] <= step:
                in_force = waiting.popleft()[1]
            step += 1
            return in_force

        return stage

    return replace(plant, stages=(*plant.stages, shared_bus)), {"delay_s": mean}


def dead_zone(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """A dead band with soft edges and not quite the same to either side.

    Beyond it what exceeds the band comes out (gear with play), or nearly all of the command (a controller's stiction).
    """
    width = here.size * here.full_torque * here.between(0.08, 0.13)
    skew = here.between(-0.12, 0.12)
    play_in_gear = here.heads()

    def gear(command: float) -> float:
        edge = width * (1.0 + math.copysign(skew, command))
        soft = 0.12 * edge
        if abs(command) > 5.0 * edge:
            return command - math.copysign(edge, command)
        beyond = math.log1p(math.exp((abs(command) - edge) / soft)) - math.log1p(math.exp(-edge / soft))
        return math.copysign(soft * beyond, command)

    def stiction(command: float) -> float:
        ratio = (abs(command) / (width * (1.0 + math.copysign(skew, command)))) ** 12
        return command * ratio / (1.0 + ratio)

    stage: Stage = gear if play_in_gear else stiction
    parameters: Parameters = {"half_width_nm": width, "shape": "gear" if play_in_gear else "stiction"}
    return replace(plant, stages=(*plant.stages, lambda: stage)), parameters


def torque_asymmetry(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """Astern the blades meet the flow with their thin edge and lose more the harder they work; or they were built in
    the other way round, and gain."""
    gained = here.size * here.either_sign(here.between(0.2, 0.36))

    def astern(command: float) -> float:
        if command >= 0.0:
            return command
        load = abs(command) / here.full_torque
        return command * (1.0 + gained * 1.3 * load / (load + 0.15))

    return replace(plant, stages=(*plant.stages, lambda: astern)), {"reverse_efficiency": 1.0 + gained}


def torque_saturation(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """Thrust that bends to a limit, a / (1 + (|a|/L)^p)^(1/p): from cavitation (p = 2.5) to a current limit (p = 8)."""
    # The square root, for about half of the thrust is lost to a limit that is that much higher.
    limit = here.full_torque * here.between(0.5, 0.65) / math.sqrt(here.size)
    sharpness = here.between(2.5, 8.0)

    def bend(command: float) -> float:
        return command / math.pow(1.0 + math.pow(abs(command) / limit, sharpness), 1.0 / sharpness)

    parameters: Parameters = {"limit_nm": limit, "shape": f"sharpness {sharpness:.1f}"}
    return replace(plant, stages=(*plant.stages, lambda: bend)), parameters


def inflow(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """The propeller runs into water that the turn brings: K_T falls with the advance ratio J ~ r/n, and a little faster
    than in proportion where the turn goes the way of the thrust."""
    share = here.size * here.between(0.2, 0.32)
    full, rate = here.full_torque, here.full_rate

    def loss(thrust: float, r: float) -> float:
        advance = r / rate
        with_it = math.copysign(0.25, thrust) * advance
        return share * math.sqrt(abs(thrust) * full) * advance * (1.0 + with_it)

    parameters: Parameters = {"coefficient": share * math.sqrt(full) / rate}
    return replace(plant, losses=(*plant.losses, loss)), parameters
