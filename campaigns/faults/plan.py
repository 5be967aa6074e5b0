"""Plan of the rows: manoeuvres, each with its cases."""

from collections.abc import Sequence

from campaigns.faults.case import Case
from campaigns.faults.catalogue import (
    FAULTS,
    GRAPH,
    IMU,
    LOCKED_START,
    NO_FAULT,
    NOISE,
    PRESSURE,
    STAMPS,
    TRANSPORT,
    WHEEL_SENSOR,
)
from campaigns.faults.manoeuvre import CORNER, FOUR_WHEELS, Manoeuvre
from vehicle_models.surfaces import TABLE_8_1

Plan = Sequence[tuple[Manoeuvre, Sequence[Case]]]

_FAULT_DEMANDS = (0.6, 1.5)
_ORDINARY = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)


def whole() -> Plan:
    """Return every car and surface: all faults at 0.6 and 1.5, ordinary and noisy braking at 0.1 to 0.9."""
    found: list[tuple[Manoeuvre, Sequence[Case]]] = []
    for car in (CORNER, FOUR_WHEELS):
        for surface in TABLE_8_1:
            for demand in sorted({*_ORDINARY, *_FAULT_DEMANDS}):
                cases = (NO_FAULT, *FAULTS) if demand in _FAULT_DEMANDS else (NO_FAULT, *NOISE)
                found.append((Manoeuvre(car, surface, demand), cases))
        found.append((Manoeuvre(car, "snow", 1.5), (LOCKED_START,)))
    return found


def quick() -> Plan:
    """Return the subset: the corner with every fault, the car with the faults that differ where wheels are compared."""
    return [
        (Manoeuvre(CORNER, "dry", 0.2), (NO_FAULT,)),
        (Manoeuvre(CORNER, "cobblestone", 0.8), (NO_FAULT, *NOISE)),
        (Manoeuvre(CORNER, "wet", 1.5), (NO_FAULT, *STAMPS, *TRANSPORT)),
        (Manoeuvre(CORNER, "dry", 0.6), (NO_FAULT, *FAULTS)),
        (Manoeuvre(FOUR_WHEELS, "dry", 0.6), (NO_FAULT, *NOISE)),
        (Manoeuvre(FOUR_WHEELS, "dry", 1.5), (NO_FAULT, *WHEEL_SENSOR, *PRESSURE, *GRAPH, *IMU)),
    ]
