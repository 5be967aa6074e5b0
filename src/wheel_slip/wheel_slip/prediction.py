"""Carries the states and hypotheses of a car's motion from one step to the next.

The road has the slope that was last seen, or has changed it since; or the accelerometer is late, turned or stuck, and
its offset changes as the accelerations of cars do; or the torques are not those of the brakes. States are in
car_motion.py.
"""

from math import exp, isfinite
from typing import Final

import numpy as np
from numpy.typing import NDArray

from wheel_slip.filter_bank import FilterBank
from wheel_slip.motion_noise import MotionNoise
from wheel_slip.step import Step
from wheel_slip.torque_odds import TorqueOdds
from wheel_slip.tyre_forces import BLIND, SLOWEST, TOLD
from wheel_slip.wheel_equation import SLOWEST_TURN, B, K, S, T, U, V

Array = NDArray[np.float64]

SLOPE_KEPT, SLOPE_CHANGED, MISREAD, MISTOLD = range(4)
"""The hypotheses."""
PRIOR: Final = np.array([0.898, 0.1, 0.001, 0.001])
"""Their probabilities at the start."""
ROW: Final = np.array([TOLD, TOLD, TOLD, BLIND])
"""By which forces each of them goes."""


class Prediction:
    """Of one car."""

    def __init__(self, noise: MotionNoise, delay: float, offset: float) -> None:
        """Take the age [s] of the accelerometer's readings, and the deviation of their offset [m/s^2]."""
        self._noise, self._delay, self._offset = noise, delay, offset
        self._drift = 0.0
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._judged = False

    def set_drift(self, variance: float) -> None:
        """Take the variance that the noise of the accelerometer brings to the speed in a second [m^2/s^3]."""
        self._drift = variance

    def mix(self, bank: FilterBank, dt: float, speed: float, reads: bool, odds: TorqueOdds, told: bool) -> None:
        """Let the hypotheses change into each other.

        Args:
            bank: the filters.
            dt: time since the last step [s].
            speed: of the car [m/s].
            reads: whether there is an accelerometer.
            odds: of the torques.
            told: whether torques are known.
        """
        p, way = self._noise, dt * abs(speed)
        known = p.slope_known**2 / (p.slope_known**2 + float(bank.p[SLOPE_CHANGED, B, B]))
        out, back = min(way / p.slope_every, 0.5), min(way / p.slope_length * known, 0.5)
        # While no brake is on, no torque can be wrong: that hypothesis follows the others, and it ends with the brakes.
        wrong, judges = odds.wrong, told and odds.judges
        # An accelerometer that is wrong stays so for a braking: else its fault would explain once what torques, if
        # they are wrong, explain all the time.
        fails, heals = dt / p.fault_every, 0.0 if judges else dt / p.fault_time
        misread, read = (fails, heals) if reads else (0.0, 1.0)
        mistold, right, stays = (
            (0.0, 0.0, 1.0) if judges else (wrong, self._judged * (1.0 - wrong), self._judged * wrong)
        )
        self._judged = judges
        misread *= 1.0 - mistold
        sound = 1.0 - misread - mistold
        change = np.array(
            [
                [sound * (1.0 - out), sound * out, misread, mistold],
                [sound * back, sound * (1.0 - back), misread, mistold],
                [0.0, 0.0, 1.0 - read, 0.0],
                [right, 0.0, 0.0, stays],
                # An accelerometer that reads the motion of the car again has any offset, on any slope.
                [0.0, read, 0.0, 0.0],
            ]
        )
        bank.mix(change, MISREAD, B, 0.0, self._offset**2)

    def predict(
        self,
        bank: FilterBank,
        step: Step,
        dt: float,
        speed: float,
        yaw_rate: float,
        beyond_brakes: tuple[float, float],
    ) -> None:
        """Go on to the end of a step.

        Args:
            bank: the filters.
            step: that ends.
            dt: its length [s].
            speed: of the car, as last known [m/s].
            yaw_rate: the same [rad/s].
            beyond_brakes: what the accelerometer read beyond the brakes' deceleration in the last two steps [m/s^2].
        """
        p, x, covariance = self._noise, bank.x, bank.p
        seen = step.reading is not None
        way, kept = step.gone, 1.0 - x[:, K]
        by_offset = way - dt * x[:, B] if seen else np.full(len(x), way)
        x[:, V] += by_offset * kept + self._delay * step.moved
        if seen:
            f = np.stack([-dt * kept, -by_offset, np.full(len(x), step.moved)], axis=1)
            covariance[:, V] += (f[:, None] @ covariance[:, [B, K, T]])[:, 0]
            covariance[:, :, V] += (covariance[:, :, [B, K, T]] @ f[:, :, None])[:, :, 0]
        between = dt / max(step.samples, 1)
        noise = dt * max(between * p.acceleration**2, self._drift) + dt * between**2 * p.jerk**2 / 3.0
        # A body that drifts in a curve feels a share of the lateral acceleration along its axis.
        across = p.sideslip * yaw_rate * speed
        covariance[:, V, V] += noise + 2.0 * p.curve_time * dt * across**2 if seen else dt * p.unknown_acceleration**2
        covariance[[SLOPE_KEPT, MISTOLD], B, B] += dt * p.offset_walk**2
        unknown = max(2.0 * p.slope**2 - float(covariance[SLOPE_CHANGED, B, B]), 0.0)
        covariance[SLOPE_CHANGED, B, B] += dt * max(abs(speed), SLOWEST) / p.slope_length * unknown
        self._misread_walk(bank, dt, *beyond_brakes)
        bank.forget(S, exp(-dt / p.slide_time), p.slide, p.slide_alike * p.slide_stddev**2)

    def turn(self, bank: FilterBank, dt: float, speed: float, measured: float | None, before: float | None) -> None:
        """Let the yaw rate follow what is measured, whose error lasts as a curve does, else let the curve end.

        Args:
            bank: the filters.
            dt: length of the step [s].
            speed: of the car [m/s].
            measured: yaw rate in this step [rad/s]; None where there is none.
            before: the same in the last step.
        """
        p, stddev = self._noise, self._noise.lateral / max(abs(speed), SLOWEST_TURN)
        towards = 0.0
        if measured is not None and before is not None:
            bank.x[:, U] += measured - before
            towards, stddev = measured, p.gyroscope
        bank.forget(U, exp(-dt / p.curve_time), towards, stddev**2)

    def _misread_walk(self, bank: FilterBank, dt: float, before: float, now: float) -> None:
        """Let the offset of a wrong accelerometer follow what it reads beyond the brakes, as the torques tell them."""
        p = self._noise
        told = isfinite(before) and isfinite(now)
        if told:
            bank.x[MISREAD, B] += now - before
        bank.p[MISREAD, B, B] += dt * (2.0 * p.engine**2 / p.engine_time if told else p.misread**2)
