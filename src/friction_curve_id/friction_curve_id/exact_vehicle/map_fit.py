"""Full-information maximum a posteriori fit of the curve over a window of samples.

The residuals are in `banded_normal_equations`, the prior in `curve_prior`. Gauss-Newton steps start from the last fit,
so one per sample suffices; samples that leave the window are folded into `past_evidence`.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.exact_vehicle.banded_normal_equations import (
    NormalEquations,
    OutlierThresholds,
    Solution,
    assemble,
    fold,
    solve,
)
from friction_curve_id.exact_vehicle.braking_window import BrakingWindow
from friction_curve_id.exact_vehicle.curve_prior import CurvePrior
from friction_curve_id.exact_vehicle.past_evidence import MOMENTUM, WHEEL_SPEED, momentum_evidence, no_evidence
from friction_curve_id.exact_vehicle.prediction import Prediction, predict
from friction_curve_id.measurement_noise import MeasurementNoise
from vehicle_models import burckhardt_log
from vehicle_models.vehicle import CornerParameters

Array = NDArray[np.float64]

_LONGEST_STEP = 0.7
"""Longest step of any coordinate of q in one iteration: a factor of two."""
_HALVINGS = 4
"""Most halvings of a step that raises the cost."""
_SETTLED = 0.1
"""A step of q below this needs no further iteration."""
_FARTHEST = 8.0
"""Largest distance of q from the prior mean, in standard deviations of the prior."""
_NO_OUTLIERS = OutlierThresholds(1e6, 1e6, 1e6)
_DRIVEN_ACCELERATION = 5.0
"""Standard deviation of the acceleration between brakings [m/s^2]: the torque of the engine is not measured."""
_START_SPEED_STDDEV = 10.0
"""Standard deviation of the first guess of u [m/s]: weak, whatever the wheel does at the start."""
_START_SPEED_DOUBT = 0.1
"""Added to the standard deviation of u at a change of surface [m/s]."""


@dataclass(frozen=True)
class FitParameters:
    """Noise, prior and memory of the fit."""

    noise: MeasurementNoise = field(default_factory=MeasurementNoise)
    prior: CurvePrior = field(default_factory=CurvePrior)
    thresholds: OutlierThresholds = field(default_factory=OutlierThresholds)
    window: int = 150
    """Most samples in the window, >= 60; the oldest third is folded when it is full."""
    memory: float = 2.0
    """Time constant with which folded samples are forgotten [s], > 0."""
    acceleration_error: float = 0.3
    """Error of the model's acceleration of the vehicle [m/s^2], > 0: drag, slope, errors of its parameters."""

    def __post_init__(self) -> None:
        """Refuse values with which no fit is possible."""
        if self.window < 60 or not (self.memory > 0.0 and self.acceleration_error > 0.0):
            raise ValueError("window must be >= 60, memory and acceleration_error > 0")


class MapFit:
    """The unknowns, their covariance, and the samples they are fitted to."""

    def __init__(self, wheel: CornerParameters, parameters: FitParameters) -> None:
        """Start from the prior."""
        self._wheel = wheel
        self._p = parameters
        self.window = BrakingWindow(wheel, parameters.window)
        self.noise = parameters.noise
        """Noise of the samples to come."""
        self._prior_mean = parameters.prior.mean
        self._prior_information = parameters.prior.information
        self._prior_reach = _FARTHEST * np.sqrt(np.diag(np.linalg.inv(self._prior_information)))
        self.robust = False
        """Whether outliers get less weight. Not while the curve itself may be far off."""
        self.forget()

    def forget(self) -> None:
        """Forget samples and curve."""
        self.window.clear()
        self.q = self._prior_mean.copy()
        """(ln th1, ln th2, ln(th3 / th1)), shape (3,)."""
        self.momentum_speed = 0.0
        """u of `braking_window` [m/s]."""
        self.covariance: Array = np.zeros((5, 5))
        """Covariance of (q, u, omega of the newest sample), shape (5, 5)."""
        self._past = no_evidence()
        self._folded_at = 0.0

    def predict(self, time: float, torque: float, equation_trust: float) -> Prediction:
        """Predict the sample at `time` [s] under `torque` [N m]."""
        return predict(
            self.window,
            self.q,
            self.momentum_speed,
            self.covariance,
            self._wheel,
            self.noise,
            time,
            torque,
            equation_trust,
        )

    def make_room(self) -> None:
        """Fold the oldest third of a full window."""
        window, p = self.window, self._p
        if window.count < window.capacity:
            return
        number = window.capacity // 3
        x = np.array([*self.q, self.momentum_speed, window.wheel_speed[number]])
        past = fold(self._equations(oldest=number), number, x)
        duration = float(window.time[number] - window.time[0])
        self._past = past.loosened(MOMENTUM, (p.acceleration_error * duration) ** 2).aged(duration, p.memory)
        window.drop_oldest(number)

    def summarise(self) -> None:
        """Fold all samples but the newest, which stays in the window unused."""
        window, last = self.window, self.window.count - 1
        x = np.array([*self.q, self.momentum_speed, window.wheel_speed[last]])
        if last > 0:
            self._past = fold(self._equations(oldest=last), last, x).without(WHEEL_SPEED)
        self._folded_at = float(window.time[last])
        window.drop_oldest(last)

    def lose_speed(self, time: float) -> None:
        """Forget speed and samples: a gap until `time` [s]. A jump back in time leaves nothing."""
        self._past = self._past.without(MOMENTUM) if time >= self._folded_at else no_evidence()
        self.window.clear()

    def go_on_after_standing(self, time: float, torque: float) -> None:
        """Let the speed of the vehicle be uncertain by what the brake could have done until `time` [s].

        While the wheel stood its brake held with `torque` [N m] at most, and no less than the road asked for.
        """
        self.summarise()
        window = self.window
        done = window.impulse_after(time, torque) - float(window.impulse[window.count - 1])
        self._past = self._past.loosened(MOMENTUM, done**2)

    def start(self) -> bool:
        """Begin to fit the samples in the window; return whether evidence of earlier ones remains."""
        window, p = self.window, self._p
        age = max(float(window.time[0]) - self._folded_at, 0.0)
        self._past = self._past.loosened(MOMENTUM, (_DRIVEN_ACCELERATION * age) ** 2).aged(age, p.memory)
        known = bool(self._past.information.any())
        if not known:
            self.q = self._prior_mean.copy()
        if self._past.information[MOMENTUM, MOMENTUM] < _START_SPEED_STDDEV**-2:
            self._guess_momentum()
        return known

    def begin_on_new_surface(self, keep: int) -> None:
        """Forget the curve and all but the newest `keep` samples; the speed of the vehicle goes on."""
        window = self.window
        window.drop_oldest(window.count - keep)
        window.wheel_speed[:keep] = window.measured_wheel_speed[:keep]
        window.wheel_speed_trust[:keep] = window.equation_trust[:keep] = 1.0
        variance = float(self.covariance[MOMENTUM, MOMENTUM]) + _START_SPEED_DOUBT**2
        self._past = momentum_evidence(self.momentum_speed, variance)
        self.q = self._prior_mean.copy()

    def iterate(self, at_most: int) -> None:
        """Make Gauss-Newton steps; one that raises the cost is halved."""
        equations, cost = self._posterior()
        for _ in range(at_most):
            solution = solve(equations)
            longest = float(np.abs(solution.step[:3]).max())
            share = min(1.0, _LONGEST_STEP / max(longest, 1e-12))
            self._move(solution, share)
            self.covariance = solution.covariance
            if longest < _SETTLED:
                return
            equations, new_cost = self._posterior()
            for _ in range(_HALVINGS):
                if new_cost <= cost:
                    break
                share *= 0.5
                self._move(solution, -share)
                equations, new_cost = self._posterior()
            cost = new_cost

    def _guess_momentum(self) -> None:
        """First guess of u: a wheel on the stable side of the curve, and the measured speeds."""
        window, wheel = self.window, self._wheel
        n = window.count
        stiffness = wheel.radius * wheel.vertical_load * burckhardt_log.steepness(self.q)
        slip = min(max(window.torque[0] / stiffness, 0.0), 0.2)
        omega = window.measured_wheel_speed[:n]
        lever = window.speed_per_wheel_speed
        guess = omega[0] * (wheel.radius / (1.0 - slip) + lever) + window.impulse[0]
        measured = window.has_speed[:n] > 0.0
        if slip > 0.01 and measured.any():
            guess = float(np.median((window.measured_speed[:n] + lever * omega + window.impulse[:n])[measured]))
        self.momentum_speed = float(guess)
        self._past.information[MOMENTUM, MOMENTUM] += _START_SPEED_STDDEV**-2
        self._past.reference[MOMENTUM] = guess

    def _equations(self, oldest: int | None = None) -> NormalEquations:
        thresholds = self._p.thresholds if self.robust else _NO_OUTLIERS
        return assemble(
            self.window, self.q, self.momentum_speed, self._wheel, self.noise, thresholds, self._past, oldest
        )

    def _posterior(self) -> tuple[NormalEquations, float]:
        """Normal equations with the prior, and the cost at the present unknowns."""
        equations = self._equations()
        offset = self.q - self._prior_mean
        gradient = self._prior_information @ offset
        equations.corner[:3, :3] += self._prior_information
        equations.corner[:3, 4] += gradient
        return equations, equations.cost + 0.5 * float(gradient @ offset)

    def _move(self, solution: Solution, share: float) -> None:
        window = self.window
        window.wheel_speed[: window.count] += share * solution.wheel_speed_step
        self.momentum_speed += share * float(solution.step[MOMENTUM])
        q = self.q + share * solution.step[:3]
        self.q = np.clip(q, self._prior_mean - self._prior_reach, self._prior_mean + self._prior_reach)
