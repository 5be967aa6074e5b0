"""Sign of the slope of each wheel of a car from the probability that it is beyond the peak, or the reason for none."""

from collections.abc import Sequence
from math import isnan, nan
from typing import Final

import numpy as np

from friction_slope.detector import DetectorParameters
from friction_slope.estimate import Method, SlopeEstimate
from friction_slope.slip_position.estimator import CarSample, SlipPosition
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle

CERTAIN: Final = 0.95
"""Probability of a sign [-]."""
MOST_UNEVENNESS: Final = 0.15
"""Relative deviation of the load that no road causes [-]: the model of the wheel does not hold."""


class _Wheel:
    """Record of one wheel."""

    def __init__(self) -> None:
        self.braked = 0
        """Time of the last sample with brake torque [ns]."""
        self.sign = 0
        """Last sign that was certain."""
        self.crossings = self.crossing_sign = 0
        self.crossing = nan, 0
        """Slip [-] and time [ns] of the last crossing."""
        self.even = nan, 0
        """The same of the last change of the more probable side, which becomes a crossing when it is certain."""
        self.side = 0

    def judge(self, probability: float, slip: float, stamp: int) -> int:
        """Return the sign, 0 where none is certain, and count crossings."""
        side = -1 if probability > 0.5 else 1
        if side != self.side:
            self.side, self.even = side, (slip, stamp)
        if max(probability, 1.0 - probability) < CERTAIN:
            return 0
        if self.sign == -side:
            self.crossings += 1
            self.crossing_sign, self.crossing = side, self.even
        self.sign = side
        return side

    def forget_sign(self) -> None:
        self.sign = self.side = 0


class CarDetector:
    """Signs of all wheels of a car."""

    def __init__(self, vehicle: Vehicle, parameters: DetectorParameters) -> None:
        """Choose a car."""
        self._p = parameters
        self._n = len(vehicle.wheels)
        self._position = SlipPosition(vehicle)
        self._low_speed = f"speed is below {parameters.minimum_speed} m/s"
        self._not_braking = f"brake torque is below {parameters.minimum_torque} N m"
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._position.reset()
        self._wheels = [_Wheel() for _ in range(self._n)]
        self._stamp: int | None = None

    def update(self, sample: CarSample) -> Sequence[SlopeEstimate]:
        """Take a sample, later than the last; return the estimate of each wheel."""
        p = self._p
        gap = self._stamp is not None and sample.stamp - self._stamp > p.max_gap * NANOSECONDS
        self._stamp = sample.stamp
        if gap:
            self._position.reset()
            for wheel in self._wheels:
                wheel.forget_sign()
                wheel.braked = 0
        torques = sample.torque.tolist()
        for wheel, torque in zip(self._wheels, torques, strict=True):
            if torque >= p.minimum_torque:
                wheel.braked = sample.stamp
        hold = p.braking_hold * NANOSECONDS
        braked = [wheel.braked > 0 and sample.stamp - wheel.braked <= hold for wheel in self._wheels]
        probabilities = self._position.update(sample, np.array(braked)).tolist()
        found = []
        for wheel, speed, torque, slip, ground, probability, is_braked, uneven, relaxed in zip(
            self._wheels,
            sample.wheel_speed.tolist(),
            torques,
            sample.slip.tolist(),
            sample.ground_speed.tolist(),
            probabilities,
            braked,
            self._position.unevenness.tolist(),
            self._position.slip.tolist(),
            strict=True,
        ):
            sign, reason, text = 0, Reason.OK, ""
            if isnan(speed):
                reason, text = Reason.BAD_INPUT, "wheel speed is missing or not finite"
            elif isnan(torque):
                reason, text = Reason.NO_PRESSURE, "no brake torque"
            elif isnan(slip):
                reason, text = Reason.NO_SLIP, "no slip"
            elif ground < p.minimum_speed:
                reason, text = Reason.LOW_SPEED, self._low_speed
            elif gap:
                reason, text = Reason.GAP, f"gap of more than {p.max_gap} s"
            elif not is_braked:
                reason, text = Reason.NOT_BRAKING, self._not_braking
            elif isnan(probability):
                reason, text = Reason.NOT_READY, "braking or road is new"
            elif self._position.slides:
                reason, text = Reason.UNCERTAIN, "car slides sideways"
            elif uneven > MOST_UNEVENNESS:
                reason, text = Reason.UNCERTAIN, "friction varies more than by slip and the load on any road"
            else:
                sign = wheel.judge(probability, relaxed, sample.stamp)
                if sign == 0:
                    reason, text = Reason.NOT_LASTING, "slip is near the peak, as far as that is known"
            if reason not in (Reason.OK, Reason.NOT_LASTING):
                wheel.forget_sign()
                probability = nan
            found.append(
                SlopeEstimate(
                    sign=sign,
                    h=nan,
                    indicator=nan,
                    delay=0.0,
                    crossings=wheel.crossings,
                    crossing_sign=wheel.crossing_sign,
                    slip_at_crossing=wheel.crossing[0],
                    crossing_stamp=wheel.crossing[1],
                    method=Method.SLIP_POSITION,
                    load_transfer=True,
                    reason=reason,
                    text=text,
                    probability=probability,
                )
            )
        return found
