"""Vehicle files that state how well their values are known."""

from collections.abc import Mapping
from dataclasses import replace

from vehicle_models.vehicle import Deviation, SharedBy, Vehicle


def stating(vehicle: Vehicle, of_car: Mapping[str, float], of_wheels: Mapping[str, float]) -> Vehicle:
    """Return a car whose file states standard deviations, beside those that it has.

    Args:
        vehicle: the car.
        of_car: each in the unit of its quantity.
        of_wheels: each over the value of its quantity.
    """
    wheels = tuple(
        replace(
            wheel,
            deviations={
                **wheel.deviations,
                **{name: Deviation(share * getattr(wheel, name), SharedBy.ALL) for name, share in of_wheels.items()},
            },
        )
        for wheel in vehicle.wheels
    )
    stated = {name: Deviation(stddev, SharedBy.ALL) for name, stddev in of_car.items()}
    return replace(vehicle, wheels=wheels, deviations={**vehicle.deviations, **stated})
