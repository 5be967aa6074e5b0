"""Samples of the whole vehicle: which may enter the fit, slips behind the tyres' relaxation, load shares."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.interface import Reason, Refusal

Array = NDArray[np.float64]

_GRAVITY = 9.81
_LARGEST_ACCELERATION = 100.0
"""[m/s^2]"""


@dataclass(frozen=True)
class VehicleParameters:
    """The vehicle, its wheels in the order of the samples."""

    radii: tuple[float, ...]
    """Effective rolling radius of each wheel [m], > 0."""
    static_shares: tuple[float, ...]
    """Share of each wheel in the load of the standing vehicle [-], > 0, sum 1."""
    transfer_shares: tuple[float, ...]
    """Change of each share per g of deceleration [-]: front h / (2 L), rear -h / (2 L); sum 0."""
    rolling_resistance: float = 0.012
    """Share of the deceleration that is rolling resistance [g]."""
    drag_per_speed_squared: float = 2.3e-4
    """Aerodynamic drag rho cd A / (2 m) [1/m]."""
    relaxation_length: float = 0.3
    """Distance over which a tyre answers to its slip [m], > 0."""
    relaxation_spread: float = 0.5
    """Standard deviation of the logarithm of that length [-], > 0."""
    timing_stddev: float = 0.01
    """Standard deviation of the shift between speed reference and wheel speeds [s], > 0."""
    min_speed: float = 6.0
    """Below it [m/s] a shift in time spoils every slip."""
    min_deceleration: float = 2.0
    """Braking, not coasting on the engine [m/s^2]."""
    max_gap: float = 0.1
    """[s]"""
    min_interval: float = 1e-3
    """Samples closer than this count as repeated [s]."""
    release_time: float = 0.5
    """Without braking for longer than this the next braking begins a new fit [s]."""

    def __post_init__(self) -> None:
        """Refuse values that make no vehicle."""
        count = len(self.radii)
        if count == 0 or len(self.static_shares) != count or len(self.transfer_shares) != count:
            raise ValueError(f"radii, static_shares and transfer_shares must be of one length >= 1: {self}")
        if not (all(r > 0.0 for r in self.radii) and all(s > 0.0 for s in self.static_shares)):
            raise ValueError(f"radii and static_shares must be > 0: {self}")
        if abs(sum(self.static_shares) - 1.0) > 1e-6 or abs(sum(self.transfer_shares)) > 1e-6:
            raise ValueError(f"static_shares must add up to 1 and transfer_shares to 0: {self}")
        for name in ("relaxation_length", "relaxation_spread", "timing_stddev", "min_speed"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be > 0, is {getattr(self, name)}")


def four_wheels(
    front_radius: float, rear_radius: float, front_share: float, height_per_wheelbase: float
) -> VehicleParameters:
    """Parameters of a car with the wheels front left, front right, rear left, rear right.

    Args:
        front_radius: [m].
        rear_radius: [m].
        front_share: load share of the front axle at rest [-].
        height_per_wheelbase: height of the centre of gravity over the wheelbase [-].
    """
    front, rear, transfer = 0.5 * front_share, 0.5 * (1.0 - front_share), 0.5 * height_per_wheelbase
    return VehicleParameters(
        (front_radius, front_radius, rear_radius, rear_radius),
        (front, front, rear, rear),
        (transfer, transfer, -transfer, -transfer),
    )


@dataclass(frozen=True)
class VehicleSample:
    """One sample of the vehicle. Anything may be garbage: it is refused where it cannot be used."""

    time: float
    """Stamp [s]."""
    speed: float
    """v [m/s]."""
    acceleration: float
    """a_x [m/s^2], forward positive."""
    wheel_speeds: tuple[float, ...]
    """omega of each wheel [rad/s]."""


@dataclass(frozen=True)
class VehiclePoint:
    """What a sample contributes to the fit. Arrays have one element a wheel."""

    slips: Array
    """Slip behind the relaxation of the tyres [-]."""
    slips_per_second: Array
    """Change of these slips per shift of the speed reference in time [1/s]."""
    slips_per_length: Array
    """Change of these slips per change of the logarithm of the relaxation length [-]."""
    shares: Array
    """Fz_i / sum of Fz [-]."""
    friction: float
    """-a_x / g - drag [-]."""
    starts_braking: bool
    """The first point of a braking."""
    after_gap: bool
    """The first point after a gap or a jump back in time."""


class VehicleSamples:
    """Makes a `VehiclePoint` of each sample taken while braking."""

    def __init__(self, parameters: VehicleParameters) -> None:
        """Start without samples."""
        self._parameters = parameters
        self._radii = np.array(parameters.radii)
        self._static = np.array(parameters.static_shares)
        self._transfer = np.array(parameters.transfer_shares)
        self.reset()

    def reset(self) -> None:
        """Forget the samples seen."""
        self._last: float | None = None
        self._after_gap = False
        self._braked_at: float | None = None
        self._slips: Array = np.zeros(len(self._radii))
        self._per_second: Array = np.zeros(len(self._radii))
        self._per_length: Array = np.zeros(len(self._radii))

    def update(self, sample: VehicleSample) -> VehiclePoint | Refusal:
        """Return what `sample` contributes, or why it contributes nothing."""
        refusal = self._refuse(sample)
        if refusal is not None:
            return refusal
        p = self._parameters
        slips = 1.0 - np.array(sample.wheel_speeds) * self._radii / sample.speed
        per_second = (1.0 - slips) * sample.acceleration / sample.speed
        last, self._last = self._last, sample.time
        if last is None or not 0.0 < sample.time - last <= p.max_gap:
            self._after_gap = self._after_gap or last is not None
            self._slips, self._per_second, self._per_length = slips, per_second, np.zeros_like(slips)
        else:
            self._relax(slips, per_second, (sample.time - last) * sample.speed / p.relaxation_length)
        if -sample.acceleration < p.min_deceleration:
            return Refusal(Reason.NO_EXCITATION, f"deceleration {-sample.acceleration:.2f} m/s^2: not braking")
        starts = self._braked_at is None or not 0.0 <= sample.time - self._braked_at <= p.release_time
        after_gap, self._after_gap, self._braked_at = self._after_gap, False, sample.time
        deceleration = -sample.acceleration / _GRAVITY
        drag = p.rolling_resistance + p.drag_per_speed_squared * sample.speed**2 / _GRAVITY
        shares = self._static + self._transfer * deceleration
        friction = deceleration - drag
        return VehiclePoint(self._slips, self._per_second, self._per_length, shares, friction, starts, after_gap)

    def _relax(self, slips: Array, per_second: Array, lengths: float) -> None:
        """Advance the tyres by so many relaxation lengths."""
        kept = float(np.exp(-lengths))
        self._per_length = kept * (self._per_length - lengths * (slips - self._slips))
        self._slips = slips + kept * (self._slips - slips)
        self._per_second = per_second + kept * (self._per_second - per_second)

    def _refuse(self, sample: VehicleSample) -> Refusal | None:
        p = self._parameters
        if len(sample.wheel_speeds) != len(self._radii):
            return Refusal(Reason.BAD_INPUT, f"{len(sample.wheel_speeds)} wheel speeds for {len(self._radii)} wheels")
        values = (sample.time, sample.speed, sample.acceleration, *sample.wheel_speeds)
        if not np.all(np.isfinite(values)):
            return Refusal(Reason.BAD_INPUT, "time, speed, acceleration or a wheel speed is not finite")
        if abs(sample.acceleration) > _LARGEST_ACCELERATION:
            return Refusal(Reason.BAD_INPUT, f"acceleration is {sample.acceleration:.3g} m/s^2")
        if sample.speed < p.min_speed:
            return Refusal(Reason.LOW_SPEED, f"vehicle speed {sample.speed:.2f} m/s is below {p.min_speed:.2f} m/s")
        if self._last is not None and abs(sample.time - self._last) < p.min_interval:
            return Refusal(Reason.BAD_INPUT, f"stamp {sample.time:.6f} s repeats {self._last:.6f} s")
        slips = 1.0 - np.array(sample.wheel_speeds) * self._radii / sample.speed
        if not np.all(np.abs(slips) < 1.0):
            return Refusal(Reason.NO_SLIP, f"a slip is outside (-1, 1): {np.round(slips, 2)}")
        return None
