"""Requirements of the single-wheel methods on the vehicle file: which values are not exact.

`default` and the methods of the chapter reckon with one wheel and its share of the car, and with torque, mass and
radius as if they were exact: their intervals hold where that is so, and miss the truth where it is not.
"""

from vehicle_models.vehicle import Deviations, Vehicle

_OF_WHEEL = ("radius", "inertia", "brake_gain")
_OF_CAR = ("mass", "brake_pressure_delay")


def not_known(vehicle: Vehicle) -> str:
    """Return what is not known exactly or moves the load of a wheel, in words; empty where there is nothing.

    Known exactly is what the vehicle file gives a standard deviation of zero. What it gives none is not known.
    """
    for name in _OF_CAR:
        if not _exact(vehicle.deviations, name):
            return _text(name, vehicle.deviations)
    for wheel in vehicle.wheels:
        for name in _OF_WHEEL:
            if not _exact(wheel.deviations, name):
                return f"{_text(name, wheel.deviations)}, at {wheel.name}"
    if any(wheel.driven for wheel in vehicle.wheels):
        if not _exact(vehicle.deviations, "engine_drag_torque"):
            return _text("engine_drag_torque", vehicle.deviations)
        if vehicle.engine_drag_torque > 0.0:
            return "the engine brakes too"
    if any(vehicle.transfer_shares):
        return "braking moves load between the axles"
    return ""


def _exact(deviations: Deviations, name: str) -> bool:
    return name in deviations and deviations[name].stddev == 0.0


def _text(name: str, deviations: Deviations) -> str:
    stated = f"has the stddev {deviations[name].stddev:.3g}" if name in deviations else "has no stddev"
    return f"'{name}' {stated} in the vehicle file"
