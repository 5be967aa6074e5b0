"""Inputs of the safety monitor: wheel speeds, slip, pressure and friction curve of one wheel."""

from collections import deque
from collections.abc import Mapping
from math import inf, isfinite, nan
from typing import Any, Final

from friction_msgs.msg import FrictionCurve, SlopeVote, WheelSlip
from sensor_msgs.msg import FluidPressure, JointState

from abs_supervisor.guard import Seen
from abs_supervisor.ros.known_curve import KnownCurve
from friction_runtime.aligner import AlignedSample
from friction_runtime.messages import speed_is_known, to_nanoseconds
from friction_runtime.processor import Report, silent
from friction_runtime.reports import of_topic
from friction_runtime.wheel_inputs import WHEEL_STATES, BrakeTorque, WheelSpeeds
from vehicle_models.physical_bounds import HIGHEST_SLIP
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

_TEXTS: Final = 20
"""Changes of the reason of a slip that are kept: a sample waits for its inputs far less long."""
Reading = tuple[int, tuple[float, ...]]


class WheelInputs:
    """Reads the messages of one wheel."""

    def __init__(self, wheel: str, vehicle: Vehicle, report: Report, fine: bool) -> None:
        """Choose a wheel of the car; messages without its speed go to `report`.

        With `fine`, as a law that trims the pressure needs it, a slip that wheel_slip is not sure of and a peak that
        the fit foresees count, with their standard deviations.
        """
        self._fine = fine
        self.brake = BrakeTorque(vehicle, wheel)
        self.slip, self.curve = f"{wheel}/slip", f"{wheel}/friction_curve"
        self.pressure = self.brake.topic
        self.sensors: Mapping[str, type] = {WHEEL_STATES: JointState, self.pressure: FluidPressure}
        self.estimates: Mapping[str, type] = {self.slip: WheelSlip, self.curve: FrictionCurve}
        self._index = vehicle.wheel_names.index(wheel)
        self._radii = vehicle.radii
        # Reports on the other wheels are left to the processors of these.
        self._own = WheelSpeeds(vehicle, (wheel,), report)
        self._all = WheelSpeeds(vehicle, vehicle.wheel_names, silent)
        self._curve = KnownCurve(foresees=fine)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._curve.reset()
        self._slip_texts: deque[tuple[int, str]] = deque(maxlen=_TEXTS)

    def take_curve(self, message: FrictionCurve) -> int:
        """Take a curve; return from which stamp on it counts [ns]."""
        return self._curve.take(message)

    def read(self, topic: str, message: Any) -> Reading | str:
        """Return stamp [ns] and values of a message for the aligner, or why it is refused.

        Validity travels as a number, so that an interpolation between a known and an unknown value is unknown.
        """
        if topic == self.pressure:
            read = self.brake.read(message)
            return read if isinstance(read, str) else (read[0], (read[1],))
        stamp = to_nanoseconds(message.header.stamp)
        if topic == WHEEL_STATES:
            speeds = self._all.read(message)
            if not isfinite(speeds[self._index]):
                self._own.read(message)  # reports why
            flagged: list[float] = []
            for speed in speeds:
                flagged.extend(_flagged(speed))
            return stamp, tuple(flagged)
        slip, stddev = message.slip, message.slip_stddev
        if not message.validity.valid:
            self._keep_text(stamp, message.validity.text)
            slip, stddev = nan, nan
            if self._fine and message.validity.reason == Reason.UNCERTAIN:
                slip, stddev = self._uncertain(message)
        known = abs(slip) <= HIGHEST_SLIP and 0.0 <= stddev < inf
        measured = float(message.speed_measured)
        flagged_slip = _flagged(slip if known else nan)
        car = _flagged(message.vehicle_speed if speed_is_known(message) else nan)
        return stamp, (*flagged_slip, stddev if known else 0.0, *car, measured)

    def _keep_text(self, stamp: int, text: str) -> None:
        """Keep why a slip is not valid, from a stamp [ns] on: a sample is told what holds for it, not the last."""
        if self._slip_texts and stamp < self._slip_texts[-1][0]:
            self._slip_texts.clear()
        if not self._slip_texts or self._slip_texts[-1][1] != text:
            self._slip_texts.append((stamp, text))

    def _slip_text(self, stamp: int) -> str:
        for since, text in reversed(self._slip_texts):
            if since <= stamp:
                return text or "not valid"
        return "not valid"

    def _uncertain(self, message: WheelSlip) -> tuple[float, float]:
        """Return slip [-] and its standard deviation where wheel_slip is not sure of it: here its error is weighed."""
        speed, radius = message.vehicle_speed, self._radii[self._index]
        if not (speed_is_known(message) and speed > 0.0):
            return nan, nan
        share = radius * message.wheel_speed / speed
        return 1.0 - share, message.vehicle_speed_stddev * abs(share / speed)

    def knows_wheel(self, topic: str, values: tuple[float, ...]) -> bool:
        """Whether the values that were read from a topic say something of this wheel: its own speed may be missing."""
        return topic != WHEEL_STATES or values[2 * self._index + 1] == 1.0

    def observe(self, sample: AlignedSample[SlopeVote], demand: float) -> Seen:
        """Return what is known at the stamp of a sample, with the driver's demand [N m], NaN where unknown."""
        own = nan
        others: list[float] = []
        flagged = sample.values.get(WHEEL_STATES, ())
        for index in range(len(flagged) // 2):
            if flagged[2 * index + 1] != 1.0:
                continue
            if index == self._index:
                own = flagged[2 * index]
            else:
                others.append(flagged[2 * index] * self._radii[index])
        slip, known, stddev, car, car_known, measured = sample.values.get(self.slip, (0.0,) * 6)
        text = ""
        if known != 1.0:
            slip, text = nan, sample.missing.get(self.slip) or of_topic(self.slip, self._slip_text(sample.stamp))
        car_speed = car if car_known == 1.0 else nan
        lambda_max, doubt = self._curve.at(sample.stamp, car_speed)
        return Seen(
            wheel_speed=own,
            demand=demand,
            others=others,
            torque=sample.values.get(self.pressure, (nan,))[0],
            slip=slip,
            slip_stddev=stddev if known == 1.0 else nan,
            car_speed=car_speed,
            car_is_measured=measured == 1.0,
            lambda_max=lambda_max,
            lambda_max_stddev=doubt,
            slip_text=text,
        )


def _flagged(value: float) -> tuple[float, float]:
    """Return a value and whether it is known, for the aligner."""
    return (value, 1.0) if isfinite(value) else (0.0, 0.0)
