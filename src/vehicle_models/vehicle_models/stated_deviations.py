"""Standard deviations of a car: those of its vehicle file, and defaults for what the file omits."""

from vehicle_models.vehicle import Deviations, Vehicle, Wheel

STATED = {
    "mass": 0.087,
    "inertia": 0.1,
    "brake_gain": 0.058,
    "radius": 0.006,
    "relaxation_length": 0.5,
    "centre_of_gravity_height": 0.06,
}
"""Relative deviations of what a vehicle file does not state."""
STATED_ABSOLUTE = {
    "front_load_share": 0.0115,
    "brake_pressure_delay": 0.012,
    "engine_drag_torque": 46.0,
    "offset": 0.17,
    "scale": 0.0115,
    "pitch_gain": 0.0015,
    "delay": 0.006,
}
"""Deviations of what a vehicle file does not state, in its units."""


def stated_deviation(deviations: Deviations, name: str) -> float | None:
    """Standard deviation of a quantity in its unit, None where its file states none."""
    return deviations[name].stddev if name in deviations else None


def deviation_of(deviations: Deviations, name: str, otherwise: float) -> float:
    """Standard deviation of a quantity in its unit, `otherwise` where its file states none."""
    found = stated_deviation(deviations, name)
    return otherwise if found is None else found


def mass_deviation(vehicle: Vehicle) -> float:
    """Relative standard deviation of the mass."""
    return deviation_of(vehicle.deviations, "mass", STATED["mass"] * vehicle.mass) / vehicle.mass


def relative_deviation(wheel: Wheel, name: str) -> float:
    """Relative standard deviation of a quantity of a wheel, of STATED where its file states none."""
    value = float(getattr(wheel, name))
    return deviation_of(wheel.deviations, name, STATED[name] * value) / value


def absolute_deviation(deviations: Deviations, name: str) -> float:
    """Standard deviation of a quantity in its unit, of STATED_ABSOLUTE where its file states none."""
    return deviation_of(deviations, name, STATED_ABSOLUTE[name])
