"""Each trouble of a real car alone, on a car that is otherwise as the estimators believe it to be."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from corner_sim.car.car_parameters import CarParameters, SensorParameters
from corner_sim.car.tyre import TYRES

ROADS = tuple(TYRES["burckhardt"])


def _gains(factor: float) -> Mapping[str, Any]:
    gains = CarParameters().brake_gain
    return {"brake_gain": tuple(factor * gain for gain in gains)}


TROUBLES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "none": {},
        "load transfer": {"height": CarParameters().height},
        "relaxation 0.3 m": {"relaxation_length": 0.3},
        "pressure 10 ms late": {"pressure_delay": 0.01},
        "pressure 20 ms late": {"pressure_delay": 0.02},
        "brake gain -10 %": _gains(0.9),
        "pads fading 20 %": {"fading": 0.2},
        "slope 5 %": {"slope": 0.05},
        "engine drag 100 N m": {"engine_drag": 100.0},
        "wheel stamps 10 ms late": {"wheel_delay": 0.01},
        "48 teeth at 100 Hz": {"encoder_teeth": 48, "sample_rate": 100},
        "Pacejka": {"family": "pacejka"},
        "load varying 5 % RMS": {"load_variation": 0.05},
    }
)
"""Changes to a car without load transfer, relaxation and errors of its sensors, by the name of the trouble."""


def troubled_car(trouble: str, road: str) -> CarParameters:
    """Make the car of a trouble on a road."""
    changes = dict(TROUBLES[trouble])
    tyre = TYRES[changes.pop("family", "burckhardt")][road]
    of_sensors = {name: changes.pop(name) for name in list(changes) if hasattr(SensorParameters, name)}
    changes.setdefault("height", 0.0)
    return replace(CarParameters(), tyres=(tyre,) * 4, sensors=SensorParameters(**of_sensors), **changes)
