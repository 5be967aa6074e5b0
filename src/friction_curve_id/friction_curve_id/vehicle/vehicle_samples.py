"""Samples of the whole vehicle: which may enter the fit, slips after the tyres' relaxation, load shares."""

from dataclasses import dataclass
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.interface import Refusal
from friction_parameters.parameter import constant, minimum_speed_parameter, parameter
from vehicle_models.constants import AIR_DENSITY, GRAVITY
from vehicle_models.physical_bounds import HIGHEST_ACCELERATION
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

_REPEATED = 1e-3
"""Samples closer than this count as repeated [s]."""
_RELEASED = 0.5
"""Without braking for longer than this the next braking begins a new fit [s]."""
_UNSTATED_SPREAD = 0.5
"""Relative standard deviation of a relaxation length that the vehicle file gives without one [-]."""


@dataclass(frozen=True)
class WholeVehicleParameters:
    """Which samples enter the fit, and the uncertainty of their timing."""

    timing_stddev: float = parameter(
        0.01,
        "standard deviation of the stamps of speed reference, wheel speeds and acceleration, each",
        unit="s",
        minimum=1e-4,
        maximum=0.1,
    )
    minimum_speed: float = minimum_speed_parameter(6.0)
    min_deceleration: float = constant(2.0, "deceleration above which the car brakes, not coasts", unit="m/s^2")
    max_gap: float = constant(0.1, "longest time between two samples of an input that is bridged", unit="s")


def relaxation_spread(vehicle: Vehicle) -> float:
    """Return the standard deviation of the logarithm of the tyres' relaxation lengths [-], an error that they share."""
    return fmean(
        wheel.deviations["relaxation_length"].stddev / wheel.relaxation_length
        if "relaxation_length" in wheel.deviations
        else _UNSTATED_SPREAD
        for wheel in vehicle.wheels
    )


@dataclass(frozen=True)
class VehicleSample:
    """One sample of the vehicle. Anything may be garbage: it is refused where it cannot be used."""

    time: float
    """Stamp [s]."""
    speed: float
    """Vehicle speed v [m/s]."""
    acceleration: float
    """Acceleration a_x [m/s^2], forward positive."""
    wheel_speeds: tuple[float, ...]
    """Speed omega of each wheel [rad/s]."""


@dataclass(frozen=True)
class VehiclePoint:
    """Contribution of a sample to the fit. Arrays have one element per wheel."""

    slips: Array
    """Slip after the relaxation of the tyres [-]."""
    slips_per_second: Array
    """Change of these slips per shift of the speed reference in time [1/s]."""
    slip_rates: Array
    """Change of these slips with time [1/s]."""
    slips_per_length: Array
    """Change of these slips per change of the logarithm of the relaxation length [-]."""
    shares: Array
    """Fz_i / sum of Fz [-]."""
    friction: float
    """-a_x / g - drag [-]."""
    starts_braking: bool
    """Whether this is the first point of a braking."""
    after_gap: bool
    """Whether this is the first point after a gap or a jump back in time."""


class VehicleSamples:
    """Makes a `VehiclePoint` of each sample taken while braking."""

    def __init__(self, vehicle: Vehicle, parameters: WholeVehicleParameters) -> None:
        """Start without samples; the wheels of a sample are in the order of `vehicle`."""
        self._parameters = parameters
        self._radii = np.array(vehicle.radii)
        self._static = np.array(vehicle.load_shares)
        self._transfer = np.array(vehicle.transfer_shares)
        self._relaxation_lengths = np.array([wheel.relaxation_length for wheel in vehicle.wheels])
        self._rolling_resistance = vehicle.rolling_resistance
        self._drag = 0.5 * AIR_DENSITY * vehicle.drag_area / vehicle.mass
        """rho cd A / (2 m) [1/m]"""
        self.reset()

    def reset(self) -> None:
        """Forget the samples seen."""
        self._last: float | None = None
        self._after_gap = False
        self._braked_at: float | None = None
        self._slips: Array = np.zeros(len(self._radii))
        self._per_second: Array = np.zeros(len(self._radii))
        self._per_length: Array = np.zeros(len(self._radii))
        self._rates: Array = np.zeros(len(self._radii))

    def update(self, sample: VehicleSample) -> VehiclePoint | Refusal:
        """Return the contribution of `sample`, or why there is none."""
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
            self._rates = np.zeros_like(slips)
        else:
            before = self._slips
            self._relax(slips, per_second, (sample.time - last) * sample.speed / self._relaxation_lengths)
            self._rates = (self._slips - before) / (sample.time - last)
        if -sample.acceleration < p.min_deceleration:
            return Refusal(Reason.NO_EXCITATION, f"waiting for a deceleration above {p.min_deceleration} m/s^2")
        starts = self._braked_at is None or not 0.0 <= sample.time - self._braked_at <= _RELEASED
        after_gap, self._after_gap, self._braked_at = self._after_gap, False, sample.time
        deceleration = -sample.acceleration / GRAVITY
        drag = self._rolling_resistance + self._drag * sample.speed**2 / GRAVITY
        shares = self._static + self._transfer * deceleration
        friction = deceleration - drag
        found = self._slips, self._per_second, self._rates, self._per_length
        return VehiclePoint(*found, shares, friction, starts, after_gap)

    def _relax(self, slips: Array, per_second: Array, lengths: Array) -> None:
        """Advance each tyre by `lengths` of its relaxation lengths."""
        kept = np.exp(-lengths)
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
        if abs(sample.acceleration) > HIGHEST_ACCELERATION:
            return Refusal(Reason.BAD_INPUT, f"acceleration is {sample.acceleration:.3g} m/s^2")
        if sample.speed < p.minimum_speed:
            return Refusal(Reason.LOW_SPEED, f"waiting for a speed above {p.minimum_speed} m/s")
        if self._last is not None and abs(sample.time - self._last) < _REPEATED:
            return Refusal(Reason.BAD_INPUT, f"stamp {sample.time:.6f} s repeats {self._last:.6f} s")
        slips = 1.0 - np.array(sample.wheel_speeds) * self._radii / sample.speed
        if not np.all(np.abs(slips) < 1.0):
            return Refusal(Reason.NO_SLIP, f"a slip is outside (-1, 1): {np.round(slips, 2)}")
        return None
