"""Motion of the car: four wheels, slips that relax, loads that move; fixed small steps.

With omega the speed of a wheel, s the slip of its tyre, u = v (1 +- track curvature / 2) the speed of its axle stub:

    J omega' = r Fz mu(s + tau_c s') - T_brake - T_drag + T_engine
    sigma s' = u - r omega - u s
    m v'     = - sum Fz mu(s + tau_c s') - c_roll sum Fz - rho/2 A v^2 - m g slope

tau_c is the damping of the tyre's carcass, without which the wheel rings on it at low speed; tau_c s' is limited to the
slip that is left to go. Forces across the car are not part of it; a curve moves load and makes wheel speeds unequal.
"""

from math import pi, sqrt

import numpy as np

from corner_sim.car.car_parameters import CarParameters, Four
from vehicle_models.constants import AIR_DENSITY, GRAVITY


class Pitch:
    """p'' + 2 zeta w p' + w^2 p = w^2 a: p [m/s^2] is the acceleration whose steady pitch the body has now."""

    def __init__(self, frequency: float, damping: float, damper_share: float) -> None:
        """Begin level. `frequency` [Hz], `damping` ratio [-], share of the dampers' force that moves load [-]."""
        self._w = 2.0 * pi * frequency
        self._two_zeta = 2.0 * damping
        self._damper_time = damper_share * self._two_zeta / self._w
        self.angle = 0.0
        """p [m/s^2]."""
        self._rate = 0.0

    @property
    def load_acceleration(self) -> float:
        """Acceleration whose steady load transfer acts now [m/s^2]: springs, and the share of the dampers."""
        return self.angle + self._damper_time * self._rate

    def step(self, acceleration: float, dt: float) -> None:
        """Advance by dt [s], short against the period, at an acceleration of the body [m/s^2]."""
        self._rate += dt * self._w * (self._w * (acceleration - self.angle) - self._two_zeta * self._rate)
        self.angle += dt * self._rate


BAND = (1.0, 14.0)
"""Frequencies [Hz]; the spectrum between them is flat."""
PERIOD = 32.0
"""Time after which the road repeats [s]."""


def load_variation(rms: float, seed: int, dt: float) -> list[tuple[float, ...]]:
    """Draw the relative load of four wheels, independent of each other.

    Args:
        rms: of the relative load of each wheel [-], >= 0; exact over the period.
        seed: same seed, same road.
        dt: time step [s].

    Returns:
        One period of relative loads around 1, each of 4.
    """
    n = round(PERIOD / dt)
    if rms == 0.0:
        return [(1.0,) * 4] * n
    frequency = np.fft.rfftfreq(n, dt)
    inside = (frequency >= BAND[0]) & (frequency <= BAND[1])
    # a stream of its own: the noise of the sensors has the same seed
    phase = np.random.default_rng([seed, 1]).uniform(0.0, 2.0 * np.pi, (inside.sum(), 4))
    spectrum = np.zeros((frequency.size, 4), dtype=complex)
    spectrum[inside] = np.exp(1j * phase)
    variation = np.fft.irfft(spectrum, n, axis=0)
    variation *= rms / np.sqrt((variation**2).mean(axis=0))
    return [tuple(row) for row in (1.0 + variation).tolist()]


GAMMA = 1.0 - sqrt(0.5)
"""Of the method ROS2, which is L-stable with it and of second order with any Jacobian."""
STEP = 1e-3
"""Time step [s]."""
SLOWEST = 1.0
"""Speed that divides the slips of a slower car [m/s]."""
_REST = 0.02
"""A braked car slower than this stands still [m/s]."""
_SIDE = (1.0, -1.0, 1.0, -1.0)
_FULL_GRIP = [1.0] * 4


class Car:
    """The car, from rolling freely in a straight line to standstill."""

    def __init__(self, parameters: CarParameters, speed: float, seed: int) -> None:
        """Begin at `speed` [m/s] > 0; `seed` is that of the road's unevenness."""
        p = self._p = parameters
        self.speed = speed
        """Speed of the body [m/s]."""
        self.wheel_speed = [speed / radius for radius in p.radius]
        """Wheel speeds [rad/s]."""
        self.acceleration = 0.0
        """Mean acceleration of the body over the last step [m/s^2]."""
        self.lateral_speed = 0.0
        """Of the centre of gravity, to the left [m/s]; this car stays on its path."""
        self.yaw_rate = 0.0
        """Counter-clockwise [rad/s]."""
        self.pitch = Pitch(p.pitch_frequency, p.pitch_damping, p.damper_share)
        self.wheel_acceleration = [0.0] * 4
        """Mean accelerations of the wheels over the last step [rad/s^2]."""
        self.distance = 0.0
        """Distance covered [m]."""
        self.tyres = list(p.tyres)
        """Tyre of each wheel on the road it is on now."""
        self._relaxed_slip = [0.0] * 4
        self._steps = 0
        self._curvature = 0.0
        self._relative_load = load_variation(p.load_variation, seed, STEP)
        front, rear = 0.5 * p.front_load_share, 0.5 * (1.0 - p.front_load_share)
        self._shares = (front, front, rear, rear)

    @property
    def vertical_load(self) -> list[float]:
        """Loads [N], >= 0: at rest, moved by pitch and by lateral acceleration, and varied by the road."""
        uneven = self._relative_load[self._steps % len(self._relative_load)]
        return [max(load * variation, 0.0) for load, variation in zip(self._even_load, uneven, strict=True)]

    @property
    def _even_load(self) -> list[float]:
        """Loads [N] on an even road."""
        p = self._p
        pitched = -0.5 * p.mass * p.height / p.wheelbase * self.pitch.load_acceleration
        rolled = -p.mass * self.speed**2 * self._curvature * p.height / p.track  # a left turn loads the right
        weight = p.mass * GRAVITY
        return [
            weight * share + end * pitched + side * rolled * share * 2.0
            for share, end, side in zip(self._shares, (1.0, 1.0, -1.0, -1.0), _SIDE, strict=True)
        ]

    @property
    def radius(self) -> list[float]:
        """Effective rolling radii under the loads on an even road [m]."""
        p = self._p
        if p.radius_loss == 0.0:
            return list(p.radius)
        weight = p.mass * GRAVITY
        return [
            radius * (1.0 - p.radius_loss * (load / (weight * share) - 1.0))
            for radius, load, share in zip(p.radius, self._even_load, self._shares, strict=True)
        ]

    @property
    def grip(self) -> list[float]:
        """Friction of each tyre over that at its load at rest."""
        p = self._p
        if p.load_sensitivity == 0.0:
            return _FULL_GRIP
        weight = p.mass * GRAVITY
        return [
            1.0 - p.load_sensitivity * (load / (weight * share) - 1.0)
            for load, share in zip(self._even_load, self._shares, strict=True)
        ]

    @property
    def friction(self) -> list[float]:
        """Fx / Fz of each tyre, braking positive."""
        return [
            grip * tyre.friction(slip)[0]
            for grip, tyre, slip in zip(self.grip, self.tyres, self.tyre_slip, strict=True)
        ]

    @property
    def tyre_slip(self) -> list[float]:
        """Slips of the tyres, s + tau_c s', of which friction is a function."""
        speed = max(self.speed, SLOWEST)
        return [
            s + self._damped_share(speed, i) * (slip - s)
            for i, (s, slip) in enumerate(zip(self._relaxed_slip, self.slip, strict=True))
        ]

    @property
    def slip(self) -> list[float]:
        """Kinematic slips (u - r omega) / u of the wheels."""
        stub = self._stub_ratio(self._curvature)
        return [
            (self.speed * ratio - radius * omega) / max(self.speed * ratio, SLOWEST)
            for radius, omega, ratio in zip(self.radius, self.wheel_speed, stub, strict=True)
        ]

    def step(
        self, brake_torque: list[float], engine_torque: float = 0.0, slope: float = 0.0, curvature: float = 0.0
    ) -> None:
        """Advance by STEP.

        Args:
            brake_torque: mean of each wheel over the step [N m], >= 0, shape (4,).
            engine_torque: at each rear wheel [N m], > 0 drives; with 0 the throttle is closed and the engine drags.
            slope: sine of the angle of the road here, uphill positive, in addition to that of the parameters.
            curvature: of the path [1/m], positive to the left.
        """
        p, h = self._p, STEP
        gh = GAMMA * h
        self._curvature = curvature
        self.yaw_rate = curvature * self.speed
        loads, grips, radii = self.vertical_load, self.grip, self.radius
        stub = self._stub_ratio(curvature)
        rear = engine_torque if engine_torque > 0.0 else -p.engine_drag
        v = self.speed
        resistance = p.rolling_resistance * sum(loads) + p.mass * GRAVITY * (slope + p.slope)
        drag = 0.5 * AIR_DENSITY * p.drag_area
        stages = []
        force_1 = resistance + drag * v * v
        for i in range(4):
            radius, inertia, load = radii[i], p.inertia[i], loads[i]
            slip_speed = max(v * stub[i], SLOWEST)
            relaxation = p.relaxation_length[i]
            rest = (v * stub[i] - radius * self.wheel_speed[i]) / slip_speed - self._relaxed_slip[i]
            damped = self._damped_share(slip_speed, i)
            mu, mu_slope = self.tyres[i].friction(self._relaxed_slip[i] + damped * rest)
            mu, mu_slope = grips[i] * mu, grips[i] * mu_slope
            force_1 += load * mu
            torque = (rear if i > 1 else 0.0) - brake_torque[i]
            wheel = (radius * load * mu + torque) / inertia
            relax = slip_speed * rest / relaxation
            stiffness = gh * radius * load * mu_slope / inertia
            b11 = 1.0 + stiffness * damped * radius / slip_speed  # b: of the inverse of 1 - gh Jacobian
            b12 = stiffness * (1.0 - damped)
            b21 = -gh * radius / relaxation
            b22 = 1.0 + gh * slip_speed / relaxation
            det = b11 * b22 - b12 * b21
            k_wheel = (b22 * wheel + b12 * relax) / det
            k_relax = (b11 * relax + b21 * wheel) / det
            stages.append((k_wheel, k_relax, b11, b12, b21, b22, det, torque))
        v_2 = v - h * force_1 / p.mass
        force_2 = resistance + drag * v_2 * v_2
        for i, (k_wheel, k_relax, b11, b12, b21, b22, det, torque) in enumerate(stages):
            radius, inertia, load = radii[i], p.inertia[i], loads[i]
            omega_2 = self.wheel_speed[i] + h * k_wheel
            slip_2 = self._relaxed_slip[i] + h * k_relax
            slip_speed = max(v_2 * stub[i], SLOWEST)
            rest = (v_2 * stub[i] - radius * omega_2) / slip_speed - slip_2
            damped = self._damped_share(slip_speed, i)
            mu = grips[i] * self.tyres[i].friction(slip_2 + damped * rest)[0]
            force_2 += load * mu
            wheel = (radius * load * mu + torque) / inertia - 2.0 * k_wheel
            relax = slip_speed * rest / p.relaxation_length[i] - 2.0 * k_relax
            omega = self.wheel_speed[i] + h * (1.5 * k_wheel + 0.5 * (b22 * wheel + b12 * relax) / det)
            omega = max(omega, 0.0)  # a brake does not turn a wheel backwards
            self.wheel_acceleration[i] = (omega - self.wheel_speed[i]) / h
            self.wheel_speed[i] = omega
            self._relaxed_slip[i] += h * (1.5 * k_relax + 0.5 * (b11 * relax + b21 * wheel) / det)
        self.acceleration = -0.5 * (force_1 + force_2) / p.mass
        self.speed = v + h * self.acceleration
        self.distance += h * 0.5 * (v + self.speed)
        if self.speed < _REST and self.acceleration < 0.0:
            self.speed, self.acceleration, self.wheel_speed = 0.0, 0.0, [0.0] * 4
        self.pitch.step(self.acceleration, h)
        self._steps += 1

    def _damped_share(self, slip_speed: float, wheel: int) -> float:
        """tau_c s' over the slip left to go: tau_c u / sigma, limited to 1."""
        way = self._p.carcass_damping * slip_speed
        return way / (self._p.relaxation_length[wheel] + way)

    def _stub_ratio(self, curvature: float) -> Four:
        """Speeds at the wheels over that of the body, which is taken at the middle of the rear axle."""
        lateral = 0.5 * self._p.track * curvature
        ahead = 1.0 + 0.5 * (self._p.wheelbase * curvature) ** 2  # the front axle runs on the wider circle
        return ((1.0 - lateral) * ahead, (1.0 + lateral) * ahead, 1.0 - lateral, 1.0 + lateral)
