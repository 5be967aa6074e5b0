"""One car of vehicle_models.two_axle in plain numbers: for one car numpy takes ten times as long as the sums.

Operations and their order are those of TwoAxleCar, and exponentials are numpy's, so that the results are equal to the
last bit; a test compares the two. The equations are explained there.
"""

import numpy as np
from numpy.typing import NDArray

from corner_sim.corner import GAMMA, REST_SPEED, SLIP_SPEED_FLOOR, inner_steps
from vehicle_models.constants import AIR_DENSITY, GRAVITY
from vehicle_models.vehicle import Vehicle, four_wheels

Array = NDArray[np.float64]
Four = list[float]

_GAMMA = float(GAMMA)
_LONGEST_STEP = 1e-3
"""Longest inner step [s]."""
_WHEELS = range(4)


def _sum(values: Four) -> float:
    return values[0] + values[1] + values[2] + values[3]


class WheelRoads:
    """Friction under each of the four wheels, as in vehicle_models.burckhardt."""

    def __init__(self, theta: Array) -> None:
        """Take the Burckhardt parameters [-] under the wheels, shape (4, 3)."""
        self._curves: list[Four] = theta.tolist()

    def friction(self, slip: Four) -> Four:
        """Friction coefficients [-] at the slips."""
        decayed: Four = np.expm1(
            [-curve[1] * abs(each) for curve, each in zip(self._curves, slip, strict=True)]
        ).tolist()
        found = []
        for curve, each, decay in zip(self._curves, slip, decayed, strict=True):
            friction = -curve[0] * decay - curve[2] * abs(each)
            found.append(friction if each > 0.0 else -friction if each < 0.0 else 0.0)
        return found

    def slope(self, slip: Four) -> Four:
        """Slopes of the friction curves [-] at the slips."""
        decayed: Four = np.exp([-curve[1] * abs(each) for curve, each in zip(self._curves, slip, strict=True)]).tolist()
        return [curve[0] * curve[1] * decay - curve[2] for curve, decay in zip(self._curves, decayed, strict=True)]


class TwoAxleCar:
    """State of one car on a level road, in neutral."""

    def __init__(self, vehicle: Vehicle, speed: float) -> None:
        """Start free rolling at `speed` [m/s], >= 0.

        Raises:
            ValueError: the vehicle does not have four wheels, left and right on each axle.
        """
        wheels = four_wheels(vehicle)
        self.radius: Four = [wheel.radius for wheel in wheels]
        """Effective rolling radii [m]."""
        self.inertia: Four = [wheel.inertia for wheel in wheels]
        """Wheel inertias [kg m^2]."""
        self.speed = speed
        """Vehicle speed v [m/s]."""
        self.wheel_speed: Four = [speed / radius for radius in self.radius]
        """Wheel speeds omega [rad/s]."""
        self.distance = 0.0
        """Distance covered [m]."""
        self._mass = vehicle.mass
        self._rolling_resistance = vehicle.rolling_resistance
        self._drag = 0.5 * AIR_DENSITY * vehicle.drag_area / vehicle.mass
        self._front_share, self._rear_share = vehicle.front_load_share, 1.0 - vehicle.front_load_share
        self._height_ratio = vehicle.height_ratio
        weight = vehicle.mass * GRAVITY
        self._front_weight, self._rear_weight = weight * self._front_share, weight * self._rear_share
        self._transfer = vehicle.mass * vehicle.height_ratio

    @property
    def slip(self) -> Four:
        """Slips [-]; relative to 0.1 m/s below that speed, so 0 at rest."""
        return self._slip(self.speed, self.wheel_speed)

    def acceleration(self, friction: Four) -> float:
        """Acceleration [m/s^2] at the friction coefficients of the wheels."""
        return self._acceleration(self.speed, friction)

    def loads(self, acceleration: float) -> Four:
        """Loads of the wheels [N] under an acceleration [m/s^2]."""
        transfer = self._transfer * acceleration
        front, rear = 0.5 * (self._front_weight - transfer), 0.5 * (self._rear_weight + transfer)
        return [front, front, rear, rear]

    def wheel_acceleration(self, friction: Four, torque: Four) -> Four:
        """Wheel accelerations [rad/s^2] at friction coefficients and under brake torques [N m]; 0 while locked."""
        free = self._wheel_acceleration(friction, self.loads(self.acceleration(friction)), torque)
        return [0.0 if w <= 0.0 and each < 0.0 else each for w, each in zip(self.wheel_speed, free, strict=True)]

    def step(self, torque_begin: Four, torque_end: Four, theta: Array, dt: float) -> None:
        """Advance by `dt` [s] under brake torques [N m] that change linearly, on the road `theta`, shape (4, 3)."""
        steps, h = inner_steps(dt, _LONGEST_STEP)
        rate = [(end - begin) / dt for begin, end in zip(torque_begin, torque_end, strict=True)]
        road = WheelRoads(theta)
        for k in range(steps):
            before = self.speed
            self._rosenbrock([torque_begin[i] + rate[i] * (k * h) for i in _WHEELS], rate, road, h)
            self.distance = self.distance + 0.5 * h * (before + self.speed)

    def _slip(self, speed: float, wheel_speed: Four) -> Four:
        radius, reference = self.radius, max(speed, SLIP_SPEED_FLOOR)
        return [(speed - wheel_speed[i] * radius[i]) / reference for i in _WHEELS]

    def _acceleration(self, speed: float, friction: Four) -> float:
        front, rear = 0.5 * (friction[0] + friction[1]), 0.5 * (friction[2] + friction[3])
        driving = GRAVITY * (self._front_share * front + self._rear_share * rear) + self._drag * (speed * speed)
        return -driving / (1.0 - self._height_ratio * (front - rear))

    def _wheel_acceleration(self, friction: Four, loads: Four, torque: Four) -> Four:
        radius, inertia, rolling = self.radius, self.inertia, self._rolling_resistance
        return [(radius[i] * loads[i] * (friction[i] - rolling) - torque[i]) / inertia[i] for i in _WHEELS]

    def _rosenbrock(self, torque: Four, rate: Four, road: WheelRoads, h: float) -> None:
        mass, radius, inertia = self._mass, self.radius, self.inertia
        v, w = self.speed, self.wheel_speed
        reference = max(v, SLIP_SPEED_FLOOR)
        slip = self._slip(v, w)
        friction = road.friction(slip)
        f_v = self._acceleration(v, friction)
        loads = self.loads(f_v)
        f_w = self._wheel_acceleration(friction, loads, torque)
        gh = _GAMMA * h
        # A locked wheel has no equation: left in, its pull below zero would reach the body through the matrix.
        turns = [w[i] > 0.0 or f_w[i] >= 0.0 for i in _WHEELS]
        by_wheel, wheel_by_v, wheel_own, force_v = [0.0] * 4, [0.0] * 4, [1.0] * 4, [0.0] * 4
        for i, road_slope in enumerate(road.slope(slip)):
            slope = loads[i] * max(road_slope, 0.0)
            rolling = w[i] * radius[i] / (reference * reference) if v > SLIP_SPEED_FLOOR else 1.0 / reference
            force_v[i] = slope * rolling
            if turns[i]:
                force_w = -slope * radius[i] / reference
                by_wheel[i] = gh * force_w / mass
                wheel_by_v[i] = -gh * radius[i] * force_v[i] / inertia[i]
                wheel_own[i] = 1.0 - gh * radius[i] * force_w / inertia[i]
        fed_back = _sum([by_wheel[i] * wheel_by_v[i] / wheel_own[i] for i in _WHEELS])
        body = 1.0 + gh * _sum(force_v) / mass - fed_back

        def solve(b_v: float, b_w: Four) -> tuple[float, Four]:
            b_w = [b_w[i] if turns[i] else 0.0 for i in _WHEELS]
            x_v = (b_v - _sum([by_wheel[i] * b_w[i] / wheel_own[i] for i in _WHEELS])) / body
            return x_v, [(b_w[i] - wheel_by_v[i] * x_v) / wheel_own[i] for i in _WHEELS]

        time_term = [-gh * rate[i] / inertia[i] for i in _WHEELS]
        k1_v, k1_w = solve(f_v, [f_w[i] + time_term[i] for i in _WHEELS])
        end_v, end_w = v + h * k1_v, [max(w[i] + h * k1_w[i], 0.0) for i in _WHEELS]
        friction = road.friction(self._slip(end_v, end_w))
        f_v = self._acceleration(end_v, friction)
        f_w = self._wheel_acceleration(friction, self.loads(f_v), [torque[i] + h * rate[i] for i in _WHEELS])
        k2_v, k2_w = solve(f_v - 2.0 * k1_v, [f_w[i] - 2.0 * k1_w[i] - time_term[i] for i in _WHEELS])
        speed = v + h * (1.5 * k1_v + 0.5 * k2_v)
        if speed < REST_SPEED and speed <= v:
            self.speed, self.wheel_speed = 0.0, [0.0] * 4
        else:
            self.speed = speed
            self.wheel_speed = [max(w[i] + h * (1.5 * k1_w[i] + 0.5 * k2_w[i]), 0.0) for i in _WHEELS]
