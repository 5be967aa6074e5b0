"""Planar motion of the car: four wheels with combined slip, yaw, roll, and a driver who steers along the path.

With x forward and y to the left, u and w the speeds of a wheel's stub along and across its plane, s the slips of its
tyre, braking positive, and sigma = hypot(s_x, s_y):

    L s_x' = u (kinematic - s_x),    kinematic = (u - r omega) / u
    L s_y' = u (w / u - s_y)
    F_x = -Fz mu(sigma) s_x / sigma,    F_y = -k Fz mu(sigma) s_y / sigma
    m (v_x' - v_y yaw') = sum F_x - drag,    m (v_y' + v_x yaw') = sum F_y,    I yaw'' = sum of their moments

k is the friction across over that along. Euler's method, wheels first, with steps of 0.5 ms.
"""

from math import cos, hypot, sin

from corner_sim.car.car import SLOWEST, STEP, Car, Pitch
from corner_sim.car.car_parameters import CarParameters
from vehicle_models.constants import AIR_DENSITY, GRAVITY

_SUBSTEPS = 2
_ROLL_FREQUENCY, _ROLL_DAMPING = 1.9, 0.4
"""Natural frequency [Hz] and damping ratio of the roll of the body."""
_REACTION = 0.12
"""Time constant of the driver's hands [s]."""
_CORRECTION = 0.25
"""Steering angle over error of the yaw rate, times the speed [m]."""
_MOST_STEERING = 0.4
"""Largest steering angle [rad]."""
_SIDE = (1.0, -1.0, 1.0, -1.0)


class CorneringCar(Car):
    """The car on a path with a curvature, which it can leave: from rolling freely along the path."""

    def __init__(self, parameters: CarParameters, speed: float, seed: int) -> None:
        """Begin straight ahead at `speed` [m/s] > 0; `seed` is that of the road's unevenness."""
        super().__init__(parameters, speed, seed)
        p = parameters
        self.lateral_acceleration = 0.0
        """Mean specific force across the car over the last step, to the left [m/s^2], without gravity by roll."""
        self.roll = Pitch(_ROLL_FREQUENCY, _ROLL_DAMPING, p.damper_share)
        self._steering = 0.0
        self._lateral_slip = [0.0] * 4
        self._ahead = p.wheelbase * (1.0 - p.front_load_share)
        self._behind = p.wheelbase * p.front_load_share
        self._yaw_inertia = p.gyration * p.mass * self._ahead * self._behind

    @property
    def _even_load(self) -> list[float]:
        p = self._p
        pitched = -0.5 * p.mass * p.height / p.wheelbase * self.pitch.load_acceleration
        rolled = p.mass * p.height / p.track * self.roll.load_acceleration
        split = (p.front_roll_stiffness,) * 2 + (1.0 - p.front_roll_stiffness,) * 2
        weight = p.mass * GRAVITY
        return [
            max(weight * share + end * pitched - side * of_axle * rolled, 0.0)
            for share, end, side, of_axle in zip(self._shares, (1.0, 1.0, -1.0, -1.0), _SIDE, split, strict=True)
        ]

    @property
    def tyre_slip(self) -> list[float]:
        """Sizes of the combined slips of the tyres, negative where they are driven."""
        return [
            hypot(s_x, s_y) if s_x >= 0.0 else -hypot(s_x, s_y)
            for s_x, s_y in zip(self._relaxed_slip, self._lateral_slip, strict=True)
        ]

    @property
    def slip(self) -> list[float]:
        """Kinematic slips along the wheels."""
        return [
            (along - radius * omega) / max(along, SLOWEST)
            for (along, _), radius, omega in zip(self._stubs(), self.radius, self.wheel_speed, strict=True)
        ]

    def step(
        self, brake_torque: list[float], engine_torque: float = 0.0, slope: float = 0.0, curvature: float = 0.0
    ) -> None:
        """Advance by STEP; see Car."""
        self._steer(curvature)
        before, wheels_before, across = self.speed, list(self.wheel_speed), 0.0
        uneven = self._relative_load[self._steps % len(self._relative_load)]
        for _ in range(_SUBSTEPS):
            across += self._substep(brake_torque, engine_torque, slope, uneven, STEP / _SUBSTEPS) / _SUBSTEPS
        # what a body feels along its axis: without the change of direction of its speed
        self.acceleration = (self.speed - before) / STEP - self.yaw_rate * self.lateral_speed
        self.lateral_acceleration = across
        self.wheel_acceleration = [
            (after - each) / STEP for after, each in zip(self.wheel_speed, wheels_before, strict=True)
        ]
        self.distance += STEP * 0.5 * (before + self.speed)
        if self.speed < 0.02:
            self.speed, self.wheel_speed, self.yaw_rate, self.lateral_speed = 0.0, [0.0] * 4, 0.0, 0.0
        self.pitch.step(self.acceleration, STEP)
        self.roll.step(across, STEP)
        self._steps += 1

    def _substep(
        self, brake_torque: list[float], engine_torque: float, slope: float, uneven: tuple[float, ...], dt: float
    ) -> float:
        """Advance by dt [s]; return the lateral specific force [m/s^2]."""
        p = self._p
        loads = [load * each for load, each in zip(self._even_load, uneven, strict=True)]
        grips, radii = self.grip, self.radius
        rear = engine_torque if engine_torque > 0.0 else -p.engine_drag
        force_x = -p.rolling_resistance * sum(loads) - p.mass * GRAVITY * (slope + p.slope)
        force_x -= 0.5 * AIR_DENSITY * p.drag_area * self.speed**2
        force_y = moment = 0.0
        c, s = cos(self._steering), sin(self._steering)
        for i, (along, across) in enumerate(self._stubs()):
            u = max(along, SLOWEST)
            radius = radii[i]
            kinematic = (along - radius * self.wheel_speed[i]) / u
            gain = min(dt * u / p.relaxation_length[i], 1.0)
            step = gain * (kinematic - self._relaxed_slip[i])
            self._relaxed_slip[i] += step
            self._lateral_slip[i] += gain * (across / u - self._lateral_slip[i])
            # the carcass damps as in Car: the slip that friction follows leads by tau s'
            s_x = self._relaxed_slip[i] + self._damped_share(u, i) * (kinematic - self._relaxed_slip[i])
            s_y = self._lateral_slip[i]
            sigma = max(hypot(s_x, s_y), 1e-9)
            force = grips[i] * self.tyres[i].friction(sigma)[0] * loads[i]
            f_x, f_y = -force * s_x / sigma, -p.across * force * s_y / sigma
            drive = (rear if i > 1 else 0.0) - brake_torque[i]
            omega = self.wheel_speed[i] + dt * (drive - radius * f_x) / p.inertia[i]
            self.wheel_speed[i] = max(omega, 0.0)
            if i < 2:
                f_x, f_y = c * f_x - s * f_y, s * f_x + c * f_y
            force_x += f_x
            force_y += f_y
            arm = self._ahead if i < 2 else -self._behind
            moment += arm * f_y - 0.5 * p.track * _SIDE[i] * f_x
        v_x, v_y, turn = self.speed, self.lateral_speed, self.yaw_rate
        self.speed += dt * (force_x / p.mass + turn * v_y)
        self.lateral_speed += dt * (force_y / p.mass - turn * v_x)
        self.yaw_rate += dt * moment / self._yaw_inertia
        return force_y / p.mass

    def _stubs(self) -> list[tuple[float, float]]:
        """Speeds of the wheels' stubs along and across their planes [m/s]."""
        half = 0.5 * self._p.track
        c, s = cos(self._steering), sin(self._steering)
        found = []
        for i, side in enumerate(_SIDE):
            v_x = self.speed - side * half * self.yaw_rate
            v_y = self.lateral_speed + (self._ahead if i < 2 else -self._behind) * self.yaw_rate
            found.append((c * v_x + s * v_y, c * v_y - s * v_x) if i < 2 else (v_x, v_y))
        return found

    def _steer(self, curvature: float) -> None:
        wanted = self._p.wheelbase * curvature
        wanted += _CORRECTION * (curvature * self.speed - self.yaw_rate)
        wanted = min(max(wanted, -_MOST_STEERING), _MOST_STEERING)
        self._steering += STEP / _REACTION * (wanted - self._steering)
