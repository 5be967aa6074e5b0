"""Nominal values of a car and its wheels, from the vehicle file."""

import numpy as np

from vehicle_models.constants import AIR_DENSITY
from vehicle_models.lateral_forces import AxleForces
from vehicle_models.vehicle import FRONT, Vehicle


class CarConstants:
    """What does not change: nominal values by wheel, shapes (W, 1)."""

    def __init__(self, vehicle: Vehicle, present: tuple[int, ...]) -> None:
        """Take the values of the vehicle file, of the wheels that are `present` by index."""
        wheels = [vehicle.wheels[each] for each in present]
        column = (len(wheels), 1)
        self.wheels = len(wheels)
        self.radius = np.array([wheel.radius for wheel in wheels]).reshape(column)
        self.inertia = np.array([wheel.inertia for wheel in wheels]).reshape(column)
        self.brake_gain = np.array([wheel.brake_gain for wheel in wheels])
        self.driven = np.array([float(wheel.driven) for wheel in wheels]).reshape(column)
        self.front = np.array([float(wheel.axle == FRONT) for wheel in wheels]).reshape(column)
        self.left = np.array([1.0 if wheel.side == "left" else -1.0 for wheel in wheels]).reshape(column)
        self.axles = AxleForces(vehicle)
        self.partner = self.axles.partner if len(present) == len(vehicle.wheels) else []
        """Other wheel of the axle of each wheel, by index; empty where not all four wheels are measured."""
        self.front_wheel, self.rear_wheel = int(np.argmax(self.front)), int(np.argmin(self.front))
        self.behind = vehicle.wheelbase * vehicle.front_load_share
        self.half_track, self.wheelbase = 0.5 * vehicle.track, vehicle.wheelbase
        self.teeth = np.array([wheel.encoder_teeth for wheel in wheels], dtype=float).reshape(column)
        share, transfer = np.array(vehicle.load_shares), np.array(vehicle.transfer_shares)
        self.transfer = transfer[list(present)].reshape(column)
        nominal = share[list(present)].reshape(column)
        self.roll = -self.left * (vehicle.centre_of_gravity_height / vehicle.track)
        """Load that a wheel gains by lateral acceleration to the left, if its axle takes all of it, over the mass."""
        one_axle = all(wheel.axle == FRONT for wheel in vehicle.wheels)
        count = np.array([sum(each.axle == wheel.axle for each in vehicle.wheels) for wheel in wheels], dtype=float)
        sign = np.where(self.front > 0.0, 1.0, -1.0) / count.reshape(column)
        self.share_sign = np.zeros(column) if one_axle else sign
        self.share_fixed = nominal - self.share_sign * vehicle.front_load_share
        self.share = nominal
        """Of the load at rest by the vehicle file."""
        self.carried_share = float(nominal.sum())
        self.mass = vehicle.mass
        self.rolling = vehicle.rolling_resistance
        self.drag = 0.5 * AIR_DENSITY * vehicle.drag_area
