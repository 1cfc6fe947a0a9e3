"""Streams that the learners of one process share: velocities of the same vehicle, and streams that arrive once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from incsvr.plant.axes import AXES, stream_of
from incsvr.signals import TORQUE, YAW_RATE
from service.host.host import Host


def share_streams(hosts: Sequence[Host]) -> None:
    """Connects learners: each receives streams that others get for it, and health names vehicles of several axes."""
    for host in hosts:
        _name_vehicle(host, hosts)
    for host in first_of_each_axis(hosts):
        _send_velocity(host, hosts)
    for other in hosts:
        first = next(host for host in hosts if _vehicle(host) == _vehicle(other))
        if first.node.config.hears(other.node.config) and other.mapped is None:
            _lead(first, other, hosts)


def first_of_each_axis(hosts: Sequence[Host]) -> list[Host]:
    """The first of several learners of the same axis of a vehicle: all receive the same."""
    found: dict[tuple[str, str], Host] = {}
    for host in hosts:
        vehicle = host.node.config.vehicle
        found.setdefault((vehicle.name, vehicle.axis), host)
    return list(found.values())


def _vehicle(host: Host) -> str:
    return host.node.config.vehicle.name


def _name_vehicle(host: Host, hosts: Sequence[Host]) -> None:
    """Health names the vehicle where learners of several of its axes are in this process."""
    vehicle = host.node.config.vehicle.name
    axes: dict[str, str] = {}
    for other in hosts:
        if other.node.config.vehicle.name == vehicle:
            axes.setdefault(other.node.config.vehicle.axis, other.keys.prefix)
    if len(axes) > 1:
        host.watch.belongs_to(vehicle, axes)


def _send_velocity(host: Host, hosts: Sequence[Host]) -> None:
    """The velocity that a learner hears goes to those of the same vehicle whose samples wait for it."""
    for other in hosts:
        for name in other.node.config.hears(host.node.config):
            if name in other.node.config.signal_settings().channels:
                _send(host, YAW_RATE, other, name)


def _lead(first: Host, other: Host, hosts: Sequence[Host]) -> None:
    """What comes to the first learner of a vehicle goes to another one: channels that it waits for, and what a
    mapping makes of the messages of others, so that each message is read once."""
    other.led_by = first.mapped
    mapped = {*first.node.config.inputs.channels, *(AXES[name].effort for name in first.further)}
    told = {name for each in hosts for name in other.node.config.hears(each.node.config)}
    for name in other.node.config.signal_settings().channels:
        if name not in told or name in mapped:
            _send(first, name, other, name)
    axis = AXES[other.node.config.vehicle.axis]
    for name, own in ((stream_of(AXES[first.node.config.vehicle.axis], axis.rate), YAW_RATE), (axis.effort, TORQUE)):
        if name in mapped:
            _send(first, name, other, own)
    if axis.effort in mapped:
        first.feed.elsewhere.add(axis.effort)


def _send(host: Host, stream: str, other: Host, name: str) -> None:
    """A stream goes to another learner, under this name."""
    host.feed.watched[stream].append(partial(other.watch.add_values, name))
    host.feed.onward[stream].append(partial(other.node.push, name))
