"""The other velocities of a body in `incsvr fit` and `incsvr trace`: with a mass matrix taken into account, else told.

Eq. 5 of one axis by itself holds where the paper says so: where the other velocities take little of its torque.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from incsvr.checks.decoupling import NeglectedTerms, neglected_terms
from incsvr.errors import BadInput
from incsvr.numerics import Array, Streams, root_mean_square
from incsvr.plant.attitude import ATTITUDE
from incsvr.plant.axes import AXES, VELOCITIES, Axis
from incsvr.plant.body import CORIOLIS, COUPLED_INERTIA, RESTORING, Coupled
from incsvr.plant.mass_and_coriolis import mass_matrix
from incsvr.plant.words import AxisWords, words_of
from incsvr.signals import TORQUE as TORQUE_STREAM
from incsvr.signals import SignalSettings
from incsvr.signals.coupled import decoupled_streams
from incsvr.signals.raw import TORQUE
from incsvr.signals.samples import Samples
from incsvr.signals.smoothing import smooth
from service.config.configuration import Config
from service.fitting.cures import cure
from service.recordings.recording import Recording, sequence
from service.recordings.samples_from_recording import samples_of, signals_for

EFFECTS_OF_REMAINDER = (
    "Coriolis, coupling and restoring terms are subtracted from the {effort} before tracing, so that effects of the "
    "thrust are sought in the remainder; the axis's own velocity is used as measured"
)
"""A template of `AxisWords`."""
BODY_PARTS = (CORIOLIS, COUPLED_INERTIA, RESTORING)


@dataclass(frozen=True, slots=True)
class OtherVelocities:
    """The role of the other velocities in a fit.

    Attributes:
        coupled: the axis in its body; None where no mass matrix was declared.
        share: of the torque's RMS, what each of the parts takes; empty without a mass matrix.
        remarks: sentences for people.
    """

    coupled: Coupled | None
    share: Mapping[str, float]
    remarks: tuple[str, ...]

    @staticmethod
    def of(coupled: Coupled | None, joined: Recording, samples: Samples, signals: SignalSettings) -> OtherVelocities:
        """The other velocities in samples of recordings that were joined."""
        if coupled is None:
            sentence = coupling_sentence(joined, samples, signals)
            return (
                NO_OTHER_VELOCITIES
                if sentence is None
                else OtherVelocities(None, {}, (f"{sentence}; {cure('other velocities', joined.axis)}",))
            )
        parts = {name: part for name, part in samples.parts.items() if name in BODY_PARTS}
        return OtherVelocities.of_parts(coupled, parts, samples.raw[TORQUE])

    @staticmethod
    def of_parts(coupled: Coupled, parts: Mapping[str, Array], left: Array) -> OtherVelocities:
        """The other velocities by what they took of the torque, (n,) each, and the residual torque (n,) [N m]."""
        torque = root_mean_square(left + np.sum(list(parts.values()), axis=0))
        share = {name: root_mean_square(part) / torque if torque > 0.0 else 0.0 for name, part in parts.items()}
        used = ", ".join(f"channel {name}" for name in (*coupled.velocities, *coupled.angles)) or "no other velocity"
        taken = ", ".join(f"{name} {100.0 * part:.0f} %" for name, part in share.items())
        remarks = [f"the mass matrix is used with {used}; parts of the {words_of(coupled.axis).effort}'s RMS: {taken}"]
        if coupled.missing:
            unknown = ", ".join(f"channel {name}" for name in coupled.missing)
            remarks.append(f"assumed zero, because they are not recorded: {unknown}")
        return OtherVelocities(coupled, share, tuple(remarks))

    def to_dict(self) -> dict[str, Any]:
        """The fields that the other velocities add to a result."""
        if self.coupled is None:
            return {}
        return {
            "coupled": {
                "mass_matrix": self.coupled.mass.ravel().tolist(),
                "velocities": list(self.coupled.velocities),
                "angles": list(self.coupled.angles),
                "taken_for_zero": list(self.coupled.missing),
                "share_of_torque": dict(self.share),
            }
        }


NO_OTHER_VELOCITIES = OtherVelocities(None, {}, ())


def coupled_axis(config: Config, axis: Axis, recordings: Sequence[Recording]) -> Coupled | None:
    """The axis in its body, with the velocities and angles that all recordings hold; None where none is declared.

    Args:
        config: whose mass matrix and weight are used.
        axis: whose equation it is.
        recordings: all that are read.

    Raises:
        BadInput: it is no mass matrix, or has nothing for this axis.
    """
    vehicle = config.vehicle
    mass = vehicle.mass_matrix
    weights = vehicle.restoring
    if mass is None and weights is None:
        return None
    own = list(AXES).index(axis.name)
    if mass is None:
        mass = tuple(vehicle.inertia if place == own else 0.0 for place in range(len(AXES)))
    matrix = mass_matrix(mass)
    if matrix[own, own] <= 0.0:
        raise BadInput(f"vehicle.mass_matrix has {matrix[own, own]:g} for {axis.name}; give a number above 0")
    common = set.intersection(*(set(_sampled(each.velocities)) for each in recordings))
    common |= set.intersection(*(set(_sampled(each.own_streams)) for each in recordings)) & {*ATTITUDE}
    return Coupled(axis, matrix, tuple(name for name in (*VELOCITIES, *ATTITUDE) if name in common), weights)


def freed_recordings(
    coupled: Coupled, recordings: Sequence[Recording]
) -> tuple[list[Recording], dict[str, Array], OtherVelocities]:
    """The recordings with what the body takes taken from the torque, each part at its stamps (n,) [N m], and what is
    told of it.

    Raises:
        BadInput: what the body asks for does not come while the torque does.
    """
    smoothing = signals_for(recordings, coupled.inertia, coupled.axis.fastest).smoothing
    freed_of, parts, left = [], [], []
    for recording in recordings:
        streams, taken = decoupled_streams(coupled, recording.streams(), smoothing)
        at, values = streams[TORQUE_STREAM]
        freed_of.append(replace(recording, own_streams={**recording.own_streams, coupled.axis.effort: (at, values)}))
        parts.append(taken)
        left.append(values)
    joined = {name: np.concatenate([each[name] for each in parts]) for name in parts[0]}
    told = OtherVelocities.of_parts(coupled, joined, np.concatenate(left))
    return freed_of, joined, replace(told, remarks=(*told.remarks, words_of(coupled.axis).fill(EFFECTS_OF_REMAINDER)))


def coupling_sentence(joined: Recording, samples: Samples, signals: SignalSettings) -> str | None:
    """The size of the coupling to other axes, as far as recorded velocities show it; None if it is small."""
    motion = {}
    for name in _sampled(joined.velocities):
        stamps, values = joined.velocities[name]
        filtered = smooth(stamps, values, samples.time, smoothing=signals.smoothing, gap=2.0 * signals.smoothing)
        motion[name] = filtered.value, filtered.slope
    found = neglected_terms(joined.axis, samples.yaw_rate, samples.damping, samples.raw[TORQUE], motion)
    return None if found is None else _sentence(found, words_of(joined.axis))


def coupling_of_recordings(recordings: Sequence[Recording], inertia: float) -> str | None:
    """The remark on recordings that are not samples yet, with a declared inertia [kg m²]."""
    if not any(recording.velocities for recording in recordings):
        return None
    joined = sequence(recordings)
    try:
        signals = signals_for(recordings, inertia, joined.axis.fastest)
        samples, _ = samples_of(joined, signals, None)
    except BadInput:  # too slow or too short for samples of Eq. 5; the tracer needs none
        return None
    return coupling_sentence(joined, samples, signals)


def _sentence(found: NeglectedTerms, words: AxisWords) -> str:
    take = "takes" if len(found.terms) == 1 else "take"
    return (
        f"the axis is coupled to others: {', '.join(found.terms)} {take} about {found.rms:.3g} {words.effort_unit} "
        f"(RMS), {100.0 * found.share:.0f} % of the {words.effort}'s {found.torque:.3g} {words.effort_unit}, which Eq. "
        "5 of one axis counts as damping"
    )


def _sampled(streams: Streams) -> tuple[str, ...]:
    """The streams that hold more than a few values."""
    return tuple(name for name, (time, _) in streams.items() if time.size > 10)
