"""The presets: where each kind of vehicle says its yaw rate, its torque and all else, as one table.

To add one is to add its rows. What they hold is chosen by `service.inputs.proposal`, in a log and on a bus alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from dataclasses import field as default
from functools import lru_cache, partial
from typing import Any, Literal

from service.inputs.owners import AUTOPILOT, autopilot_message, base, keelson_subject
from service.inputs.table import StampUnit, Topic

OUTPUT_MESSAGE = "SERVO_OUTPUT_RAW"
"""The message with the outputs of an autopilot on a link."""
COMMAND = "command"
"""The quantity of a row that tells what thrusters are told: a vehicle whose commands change moves."""


@dataclass(frozen=True, slots=True)
class Row:
    """Where the messages of one kind hold a quantity.

    Attributes:
        quantity: yaw_rate, torque, armed, `COMMAND`, or the name of a channel.
        kind: of the messages: their type in ROS, their subject in Keelson, else their name.
        field: path of the number; in JSON of MAVLink within `message`.
        unit: of the number; empty where it is SI.
        sign: -1 if it is positive in the other direction.
        stamp: path of the stamp, if messages bear one that counts.
        stamp_unit: its unit.
        beside: whether the topic of the yaw rate alone is asked for it.
        otherwise: whether it is asked for only where nothing else has the quantity.
        moving: whether it is taken from a log alone, where its values move: many drivers leave it empty.
        armed: of `armed`, how the number says so, as in the section `inputs`; where it is empty, any but 0 does.
    """

    quantity: str
    kind: str
    field: str
    unit: str = ""
    sign: Literal[1, -1] = 1
    stamp: str = ""
    stamp_unit: StampUnit = "s"
    beside: bool = False
    otherwise: bool = False
    moving: bool = False
    armed: Mapping[str, Any] = default(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Preset:
    """A kind of vehicle, or of its logs.

    Attributes:
        name: as people write it.
        kind: of a topic's messages; empty where they are none of this preset's.
        rows: what they hold.
        keys: key expressions that are listened to on a bus, with `{}` for a kind; empty where only logs are read.
        heard: kinds that are listened to beside those of the rows.
        form: of a message on a bus; `cdr` stands for CDR of its type.
        why: by what one of several topics is taken.
        outputs: the message with ArduSub's outputs, of which the torque is made; empty where it is not.
        torque: the cure where the torque is not found; empty for the usual one.
        commands: kinds that may hold the commands of thrusters, to be named in that cure.
    """

    name: str
    kind: Callable[[Topic], str]
    rows: tuple[Row, ...]
    keys: str = ""
    heard: tuple[str, ...] = ()
    form: str = "json"
    why: str = "the lowest number"
    outputs: str = ""
    torque: str = ""
    commands: tuple[str, ...] = ()

    @property
    def listened(self) -> tuple[str, ...]:
        """The kinds that are listened to on a bus."""
        kinds = (*(row.kind for row in self.rows if row.quantity != COMMAND and not row.moving), *self.heard)
        return tuple(dict.fromkeys(kinds)) if self.keys else ()

    def expressions(self) -> tuple[str, ...]:
        """The key expressions that are listened to on a bus."""
        return tuple(self.keys.format(kind.replace("/msg/", "::msg::dds_::")) for kind in self.listened)


def _message(topic: Topic) -> str:
    """The MAVLink message of an autopilot that a topic holds, without its instance."""
    return base(autopilot_message(topic) or "")


_of_boot = partial(Row, stamp="time_boot_ms", stamp_unit="ms")
_MAVLINK = Preset(
    "blueos",
    _message,
    (
        _of_boot("yaw_rate", "ATTITUDE", "yawspeed", "rad/s"),
        _of_boot("heading", "ATTITUDE", "yaw", "rad", beside=True),
        _of_boot("roll_rate", "ATTITUDE", "rollspeed", "rad/s", beside=True),
        _of_boot("pitch_rate", "ATTITUDE", "pitchspeed", "rad/s", beside=True),
        Row("voltage", "BATTERY_STATUS", "voltages[0]", "mV"),
        Row("voltage", "SYS_STATUS", "voltage_battery", "mV", otherwise=True),
        Row("depth", "VFR_HUD", "alt", "m", sign=-1),
        Row("armed", "HEARTBEAT", "base_mode", armed={"bit": 128}),  # MAV_MODE_FLAG_SAFETY_ARMED
    ),
    keys=f"mavlink/*/{AUTOPILOT}/{{}}",
    heard=(OUTPUT_MESSAGE, "PARAM_VALUE"),
    outputs=OUTPUT_MESSAGE,
)
"""MAVLink on a link: telemetry logs, and the JSON of BlueOS's Zenoh router and recorder. Its axes are north, east,
down: yaw counts clockwise seen from above, and so does the moment that is made of ArduSub's outputs."""

_of_autopilot = partial(Row, stamp="TimeUS", stamp_unit="us")
_DATAFLASH = Preset(
    "blueos",
    lambda topic: base(topic.name),
    (
        _of_autopilot("yaw_rate", "IMU", "GyrZ", "rad/s"),
        _of_autopilot("heading", "ATT", "Yaw", "deg"),
        _of_autopilot("roll_rate", "IMU", "GyrX", "rad/s", beside=True),
        _of_autopilot("pitch_rate", "IMU", "GyrY", "rad/s", beside=True),
        _of_autopilot("voltage", "BAT", "Volt", "V"),
        _of_autopilot("armed", "ARM", "ArmState", armed={"events": True}),
        _of_autopilot("armed", "EV", "Id", otherwise=True, armed={"equals": 10.0, "disarmed": 11.0, "events": True}),
    ),
    outputs="RCOU",
)
"""ArduPilot's own logs (.BIN): the gyro, the outputs and the arming as the autopilot wrote them down. Of all events
(EV.Id) only those of arming and disarming say something of it."""

_of_px4 = partial(Row, stamp="timestamp", stamp_unit="us")
_PX4 = Preset(
    "px4",
    lambda topic: base(topic.name),
    (
        _of_px4("yaw_rate", "vehicle_angular_velocity", "xyz[2]", "rad/s"),
        _of_px4("roll_rate", "vehicle_angular_velocity", "xyz[0]", "rad/s", beside=True),
        _of_px4("pitch_rate", "vehicle_angular_velocity", "xyz[1]", "rad/s", beside=True),
        _of_px4("torque", "vehicle_torque_setpoint", "xyz[2]", "fraction"),
        _of_px4("voltage", "battery_status", "voltage_v", "V"),
        _of_px4("armed", "actuator_armed", "armed"),
        _of_px4("armed", "vehicle_status", "arming_state", otherwise=True, armed={"equals": 2.0}),
    ),
)
"""PX4's logs: the rates, and the torque that the controller asked for as a part of what the vehicle can. The third
axis points downwards: clockwise seen from above."""

_of_keelson = partial(Row, stamp="timestamp")
_KEELSON = Preset(
    "keelson",
    lambda topic: keelson_subject(topic.name) or "",
    (
        _of_keelson("yaw_rate", "yaw_rate_degps", "value", "deg/s"),
        Row("armed", "vehicle_armed", "value"),
        _of_keelson("heading", "yaw_deg", "value", "deg"),
        _of_keelson("heading", "heading_true_north_deg", "value", "deg", otherwise=True),
        _of_keelson("roll_rate", "roll_rate_degps", "value", "deg/s"),
        _of_keelson("pitch_rate", "pitch_rate_degps", "value", "deg/s"),
        _of_keelson("surge", "surge_velocity_mps", "value", "m/s"),
        _of_keelson("sway", "sway_velocity_mps", "value", "m/s"),
        _of_keelson("voltage", "battery_voltage_v", "value", "V"),
        _of_keelson("rudder_angle", "rudder_angle_deg", "value", "deg"),
        Row(COMMAND, "propeller_rate_rpm", "value"),
        Row(COMMAND, "engine_throttle_pct", "value"),
    ),
    keys="**/@v0/**/pubsub/{}/**",
    form="keelson",
    why="the first by its name",
    torque="Keelson sends no torque: it is computed from the propellers and the rudder; describe them in "
    "inputs.thrusters of a configuration (propeller_rate_rpm, rudder_angle_deg)",
)
"""Keelson, the maritime conventions on Zenoh: the subject in a key says what it is and in which unit."""

_of_ros = partial(Row, stamp="header.stamp")
_moving = partial(_of_ros, moving=True)
ROS2 = Preset(
    "ros2",
    lambda topic: topic.type,
    (
        _of_ros("yaw_rate", "sensor_msgs/msg/Imu", "angular_velocity.z", "rad/s"),
        _of_ros("yaw_rate", "nav_msgs/msg/Odometry", "twist.twist.angular.z", "rad/s"),
        _of_ros("yaw_rate", "geometry_msgs/msg/TwistWithCovarianceStamped", "twist.twist.angular.z", "rad/s"),
        _of_ros("yaw_rate", "geometry_msgs/msg/TwistStamped", "twist.angular.z", "rad/s"),
        _of_ros("yaw_rate", "geometry_msgs/msg/Vector3Stamped", "vector.z", "rad/s"),
        _of_ros("torque", "geometry_msgs/msg/WrenchStamped", "wrench.torque.z", "N m"),
        _of_ros("torque", "geometry_msgs/msg/Wrench", "torque.z", "N m"),
        _of_ros("surge", "nav_msgs/msg/Odometry", "twist.twist.linear.x", "m/s"),
        _of_ros("sway", "nav_msgs/msg/Odometry", "twist.twist.linear.y", "m/s"),
        *(
            _moving(name, f"geometry_msgs/msg/{kind}", f"{path}linear.{axis}", "m/s")
            for kind, path in (("TwistWithCovarianceStamped", "twist.twist."), ("TwistStamped", "twist."))
            for name, axis in (("surge", "x"), ("sway", "y"), ("heave", "z"))
        ),
        _moving("heave", "nav_msgs/msg/Odometry", "twist.twist.linear.z", "m/s"),
        *(
            _moving(f"{name}_force", f"geometry_msgs/msg/{kind}", f"{path}force.{axis}", "N")
            for kind, path in (("WrenchStamped", "wrench."), ("Wrench", ""))
            for name, axis in (("surge", "x"), ("sway", "y"), ("heave", "z"))
        ),
        _moving("heading", "sensor_msgs/msg/Imu", "orientation.yaw", "rad"),
        _moving("heading", "nav_msgs/msg/Odometry", "pose.pose.orientation.yaw", "rad"),
        _moving("heading", "geometry_msgs/msg/PoseWithCovarianceStamped", "pose.pose.orientation.yaw", "rad"),
        _moving("heading", "geometry_msgs/msg/PoseStamped", "pose.orientation.yaw", "rad"),
        _of_ros("roll_rate", "sensor_msgs/msg/Imu", "angular_velocity.x", "rad/s", beside=True),
        _of_ros("pitch_rate", "sensor_msgs/msg/Imu", "angular_velocity.y", "rad/s", beside=True),
        Row("armed", "mavros_msgs/msg/State", "armed"),
    ),
    keys="*/**/{}_/*",
    form="cdr",
    why="the first by its name",
    commands=("std_msgs/msg/Float64MultiArray", "mavros_msgs/msg/RCOut"),
)
"""ROS 1 and ROS 2, by the types of the messages; ROS's axes count counter-clockwise, torque and rate alike."""

PRESETS = (_MAVLINK, _DATAFLASH, _PX4, _KEELSON, ROS2)
"""All, in the order in which they look at a log."""
NAMES = ("blueos", "ros2", "keelson", "px4", "incsvr")
"""The names of all; `incsvr` are our own recordings and keys."""
ON_BUS = tuple(name for name in NAMES if any(each.name == name and each.keys for each in PRESETS))
"""The names of those that speak on a bus of the vehicle's."""
RATE_PATHS, TORQUE_PATHS = (
    {row.kind: row.field for row in ROS2.rows if row.quantity == name} for name in ("yaw_rate", "torque")
)
"""Paths of the yaw rate and of the torque by the type of a ROS message."""
NO_RATE_FIELD = "angular_velocity_covariance[0]"
"""−1 in an Imu that has no rate."""


def expressions(name: str) -> tuple[str, ...]:
    """The key expressions that a preset listens to on a bus; none of one for logs."""
    return tuple(key for preset in PRESETS if preset.name == name for key in preset.expressions())


def holding(topic: Topic, quantity: str) -> tuple[Preset, Row] | None:
    """The first preset and its row by which a topic holds a quantity; None where none does."""
    return _holding(topic.name, topic.type, topic.system).get(quantity)


@lru_cache(4096)  # on a bus this is asked of every key each time that a new one is heard
def _holding(name: str, kind: str, system: str) -> dict[str, tuple[Preset, Row]]:
    topic = Topic(name, kind, (), 0, system)
    rows = [(preset, row) for preset in reversed(PRESETS) for row in preset.rows if preset.kind(topic) == row.kind]
    return {row.quantity: (preset, row) for preset, row in rows}
