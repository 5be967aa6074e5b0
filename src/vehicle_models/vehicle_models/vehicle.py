"""The car: parameters of it and of each of its wheels, with their uncertainty. Files: see vehicle_file."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from enum import Enum
from math import inf, nan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from friction_parameters.parameter import parameter
from vehicle_models import burckhardt
from vehicle_models.constants import GRAVITY

Array = NDArray[np.float64]

_REQUIRED = nan
"""Default of a required value; NaN passes no check."""
FRONT, REAR = "front", "rear"


class SharedBy(Enum):
    """Which wheels share the error of a quantity. This decides whether the errors of wheels average out."""

    WHEEL = "wheel"
    AXLE = "axle"
    ALL = "all"


@dataclass(frozen=True)
class Deviation:
    """Uncertainty of a value."""

    stddev: float
    """Standard deviation in the unit of the value, >= 0; zero: known exactly."""
    shared_by: SharedBy
    """Level at which it was stated: one wheel, an axle, all wheels (or the whole car)."""


Deviations = Mapping[str, Deviation]
"""Deviations by the name of the quantity. A missing one is not stated, which does not mean that the value is exact."""


def _deviations() -> Any:
    return field(default_factory=dict, metadata={"internal": True})


def _refuse_impossible(part: Any) -> None:
    """Refuse impossible values. The ranges of the fields are for files: merely unusual values pass here."""
    for each in fields(part):
        low, value = each.metadata.get("minimum"), getattr(part, each.name)
        if low is not None and not (0.0 < value < inf or (low == 0.0 == value)):
            raise ValueError(f"'{each.name}' = {value} must be finite and {'>=' if low == 0.0 else '>'} 0")


@dataclass(frozen=True)
class CornerParameters:
    """A wheel and the share of the car that rests on it."""

    radius: float
    """Effective rolling radius r [m]."""
    inertia: float
    """Wheel inertia J [kg m^2]."""
    mass: float
    """Mass m that this wheel decelerates [kg]."""
    vertical_load: float
    """Fz at rest [N]."""

    def __post_init__(self) -> None:
        """Refuse values without physical meaning."""
        for name in ("radius", "inertia", "mass", "vertical_load"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name} must be finite and > 0, is {getattr(self, name)}")

    @property
    def gravity(self) -> float:
        """Gravity as Fz / m [m/s^2]."""
        return self.vertical_load / self.mass

    def peak_torque(self, theta: ArrayLike) -> Array:
        """Brake torque [N m] that holds the corner at the peak: mu_max (r Fz + J (1 - lambda_max) g / r).

        From (2.15) at constant slip, where omega_dot = (1 - slip) v_dot / r.
        """
        lambda_max, mu_max = burckhardt.peak(theta)
        return np.asarray(
            mu_max * (self.radius * self.vertical_load + self.inertia * (1.0 - lambda_max) * self.gravity / self.radius)
        )


@dataclass(frozen=True)
class Wheel:
    """One wheel with its brake."""

    name: str
    """Name of the wheel, with which its topics begin."""
    joint: str
    """Name of the wheel in wheel_states."""
    axle: str = parameter(FRONT, "axle it is on", choices=(FRONT, REAR))
    side: str = parameter("left", "side it is on", choices=("left", "right"))
    radius: float = parameter(_REQUIRED, "effective rolling radius r", unit="m", minimum=0.05, maximum=2.0)
    inertia: float = parameter(_REQUIRED, "moment of inertia J", unit="kg m^2", minimum=0.01, maximum=100.0)
    brake_gain: float = parameter(_REQUIRED, "k of T_b = k p (1.1)", unit="N m/Pa", minimum=1e-7, maximum=1.0)
    encoder_teeth: int = parameter(48, "teeth of the encoder", minimum=8, maximum=1000)
    driven: bool = parameter(False, "the engine drives it")
    relaxation_length: float = parameter(
        0.3, "distance over which its tyre responds to slip", unit="m", minimum=1e-3, maximum=3.0
    )
    radius_loss: float = parameter(
        0.023, "share of the rolling radius that its tyre loses where its load doubles", minimum=0.0, maximum=0.2
    )
    deviations: Deviations = _deviations()

    def __post_init__(self) -> None:
        """Refuse values without physical meaning.

        Raises:
            ValueError: a value is missing, not finite or not positive.
        """
        _refuse_impossible(self)


@dataclass(frozen=True)
class Accelerometer:
    """Mounting of the accelerometer of `imu/data`, and its known errors."""

    axis: str = parameter("x", "its axis along the car", choices=("x", "y", "z"))
    sign: float = parameter(1.0, "1 if that axis points forward, -1 if backward", minimum=-1.0, maximum=1.0)
    bias: float = parameter(
        0.0, "its reading at rest on a level road, after 'sign'", unit="m/s^2", minimum=-20.0, maximum=20.0
    )
    scale: float = parameter(1.0, "change of its reading over change of acceleration", minimum=0.5, maximum=2.0)
    pitch_gain: float = parameter(
        0.0, "pitch of the body, nose down, over deceleration", unit="rad s^2/m", minimum=0.0, maximum=0.02
    )
    delay: float = parameter(0.0, "age of a reading at its stamp", unit="s", minimum=0.0, maximum=0.1)
    deviations: Deviations = _deviations()

    def __post_init__(self) -> None:
        """Refuse a sign that is neither 1 nor -1."""
        if abs(self.sign) != 1.0:
            raise ValueError(f"'sign' = {self.sign} must be 1 or -1")

    def forward(self, linear_acceleration: Any) -> float:
        """Acceleration of the car [m/s^2], forward positive, on a level road.

        A nose that dives adds a share of gravity to the reading: sign f = scale (1 + g pitch_gain) a + bias.

        Args:
            linear_acceleration: vector with x, y, z [m/s^2], as in sensor_msgs/Imu.
        """
        return self.without_bias(linear_acceleration) / (self.scale * (1.0 + GRAVITY * self.pitch_gain))

    def without_bias(self, linear_acceleration: Any) -> float:
        """Reading [m/s^2], forward positive, of which only the bias is removed: pitch and scale are in it."""
        return self.sign * float(getattr(linear_acceleration, self.axis)) - self.bias

    def reading(self, acceleration: float) -> float:
        """Reading of `axis` [m/s^2] at an acceleration of the car [m/s^2], the inverse of `forward`."""
        return self.sign * (self.scale * (1.0 + GRAVITY * self.pitch_gain) * acceleration + self.bias)


@dataclass(frozen=True)
class Vehicle:
    """A car on two axles, or a single corner: then all its wheels are on the front axle."""

    name: str
    wheels: tuple[Wheel, ...]
    """Wheels in the order of every array per wheel."""
    mass: float = parameter(_REQUIRED, "mass of the car as driven", unit="kg", minimum=1.0, maximum=1e5)
    front_load_share: float = parameter(1.0, "share of the weight on the front axle at rest", minimum=0.05, maximum=1.0)
    wheelbase: float = parameter(2.7, "distance of the axles", unit="m", minimum=0.5, maximum=20.0)
    centre_of_gravity_height: float = parameter(
        0.0, "height of the centre of gravity", unit="m", minimum=0.0, maximum=5.0
    )
    pitch_frequency: float = parameter(
        1.5, "natural frequency with which the body pitches", unit="Hz", minimum=0.3, maximum=10.0
    )
    pitch_damping: float = parameter(0.3, "damping ratio of that motion", minimum=0.05, maximum=0.95)
    front_roll_share: float = parameter(
        0.55,
        "share of the roll moment that the front axle takes, by springs and stabilisers",
        minimum=0.05,
        maximum=0.95,
    )
    track: float = parameter(1.5, "distance of the wheels of an axle", unit="m", minimum=0.3, maximum=5.0)
    drag_area: float = parameter(0.0, "drag coefficient times frontal area", unit="m^2", minimum=0.0, maximum=20.0)
    rolling_resistance: float = parameter(0.0, "coefficient of rolling resistance", minimum=0.0, maximum=0.5)
    engine_drag_torque: float = parameter(
        0.0,
        "torque of the closed throttle at each driven wheel, braking positive",
        unit="N m",
        minimum=0.0,
        maximum=1e4,
    )
    front_yaw_moment_rate: float = parameter(
        0.0,
        "fastest growth of the yaw moment of the front brakes on split friction, 0: no limit",
        unit="N m/s",
        minimum=0.0,
        maximum=1e6,
    )
    brake_pressure_delay: float = parameter(0.0, "age of a pressure at its stamp", unit="s", minimum=0.0, maximum=0.5)
    accelerometer: Accelerometer = field(default_factory=Accelerometer, metadata={"internal": True})
    deviations: Deviations = _deviations()

    def __post_init__(self) -> None:
        """Refuse a car that is not possible.

        Raises:
            ValueError: a value is missing, not finite or not positive, there are no wheels, two share a name, joint or
                place, or the load share does not fit the axles. The text begins with the field.
        """
        _refuse_impossible(self)
        if self.pitch_damping >= 1.0:
            raise ValueError(f"'pitch_damping' = {self.pitch_damping} must be below 1")
        if not self.wheels:
            raise ValueError("'wheels' must name at least one wheel")
        for what, of_wheels in (
            ("name", self.wheel_names),
            ("joint", self.joints),
            ("place", tuple(f"{wheel.axle} {wheel.side}" for wheel in self.wheels)),
        ):
            if twice := [each for each in of_wheels if of_wheels.count(each) > 1]:
                raise ValueError(f"'wheels': two have the {what} '{twice[0]}'")
        axles = {wheel.axle for wheel in self.wheels}
        if FRONT not in axles:
            raise ValueError("'wheels': none is on the axle 'front'")
        if (self.front_load_share < 1.0) != (REAR in axles):
            where = "a wheel is" if REAR in axles else "no wheel is"
            raise ValueError(f"'front_load_share' = {self.front_load_share} does not fit: {where} on the axle 'rear'")

    @property
    def wheel_names(self) -> tuple[str, ...]:
        """Names of the wheels."""
        return tuple(wheel.name for wheel in self.wheels)

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the wheels in wheel_states."""
        return tuple(wheel.joint for wheel in self.wheels)

    @property
    def radii(self) -> tuple[float, ...]:
        """Effective rolling radii [m]."""
        return tuple(wheel.radius for wheel in self.wheels)

    @property
    def height_ratio(self) -> float:
        """Height of the centre of gravity over the wheelbase, h / L [-]."""
        return self.centre_of_gravity_height / self.wheelbase

    @property
    def load_shares(self) -> tuple[float, ...]:
        """Share of each wheel in the weight at rest [-], sum 1."""
        return tuple(self._load_share(wheel) for wheel in self.wheels)

    @property
    def transfer_shares(self) -> tuple[float, ...]:
        """Change of each of these shares per g of deceleration [-], sum 0: h / L, divided among an axle's wheels."""
        if all(wheel.axle == FRONT for wheel in self.wheels):
            return (0.0,) * len(self.wheels)
        signs = {FRONT: 1.0, REAR: -1.0}
        return tuple(signs[wheel.axle] * self.height_ratio / self._count(wheel.axle) for wheel in self.wheels)

    @property
    def roll_shares(self) -> tuple[float, ...]:
        """Change of each of these shares per g of acceleration to the left [-]; 0 without all four wheels."""
        if len(self.wheels) < 4:
            return (0.0,) * len(self.wheels)
        of_axle = {FRONT: self.front_roll_share, REAR: 1.0 - self.front_roll_share}
        moved = self.centre_of_gravity_height / self.track
        return tuple((-1.0 if wheel.side == "left" else 1.0) * of_axle[wheel.axle] * moved for wheel in self.wheels)

    def wheel(self, name: str) -> Wheel:
        """Return a wheel by its name.

        Raises:
            KeyError: there is no wheel of this name.
        """
        for wheel in self.wheels:
            if wheel.name == name:
                return wheel
        raise KeyError(f"'{self.name}' has no wheel '{name}', it has {', '.join(self.wheel_names)}")

    def corner(self, name: str) -> CornerParameters:
        """Return a wheel with the share of the mass that rests on it."""
        wheel = self.wheel(name)
        mass = self.mass * self._load_share(wheel)
        return CornerParameters(wheel.radius, wheel.inertia, mass, mass * GRAVITY)

    def _load_share(self, wheel: Wheel) -> float:
        share = self.front_load_share if wheel.axle == FRONT else 1.0 - self.front_load_share
        return share / self._count(wheel.axle)

    def _count(self, axle: str) -> int:
        return sum(wheel.axle == axle for wheel in self.wheels)


_CORNERS = ((FRONT, "left"), (FRONT, "right"), (REAR, "left"), (REAR, "right"))
"""Order of the last dimension of every array per wheel."""


def four_wheels(vehicle: Vehicle) -> tuple[Wheel, ...]:
    """Wheels in the order of the arrays: front left, front right, rear left, rear right.

    Raises:
        ValueError: the vehicle does not have these four.
    """
    at = {(wheel.axle, wheel.side): wheel for wheel in vehicle.wheels}
    if set(at) != set(_CORNERS):
        raise ValueError(
            f"a car on two axles has four wheels, left and right on each axle; those of '{vehicle.name}' are "
            f"{', '.join(f'{wheel.name} ({wheel.axle} {wheel.side})' for wheel in vehicle.wheels)}"
        )
    return tuple(at[corner] for corner in _CORNERS)


STATED = {
    "mass": 0.087,
    "inertia": 0.1,
    "brake_gain": 0.058,
    "radius": 0.006,
    "relaxation_length": 0.5,
    "centre_of_gravity_height": 0.06,
}
"""Relative deviations of what a vehicle file does not state."""
STATED_ABSOLUTE = {
    "front_load_share": 0.0115,
    "front_roll_share": 0.05,
    "radius_loss": 0.007,
    "brake_pressure_delay": 0.012,
    "engine_drag_torque": 46.0,
    "bias": 0.17,
    "scale": 0.0115,
    "pitch_gain": 0.0015,
    "delay": 0.006,
}
"""Deviations of what a vehicle file does not state, in its units."""


def specified_stddev(deviations: Deviations, name: str) -> float | None:
    """Standard deviation of a quantity in its unit, None where its file states none."""
    return deviations[name].stddev if name in deviations else None


def deviation_of(deviations: Deviations, name: str, otherwise: float) -> float:
    """Standard deviation of a quantity in its unit, `otherwise` where its file states none."""
    found = specified_stddev(deviations, name)
    return otherwise if found is None else found


def mass_deviation(vehicle: Vehicle) -> float:
    """Relative standard deviation of the mass."""
    return deviation_of(vehicle.deviations, "mass", STATED["mass"] * vehicle.mass) / vehicle.mass


def relative_deviation(wheel: Wheel, name: str) -> float:
    """Relative standard deviation of a quantity of a wheel, of STATED where its file states none."""
    value = float(getattr(wheel, name))
    return deviation_of(wheel.deviations, name, STATED[name] * value) / value


def absolute_deviation(deviations: Deviations, name: str) -> float:
    """Standard deviation of a quantity in its unit, of STATED_ABSOLUTE where its file states none."""
    return deviation_of(deviations, name, STATED_ABSOLUTE[name])
