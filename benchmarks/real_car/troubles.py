"""Each trouble of a real car alone, on a car that is otherwise as the estimator that is judged believes it to be.

The default believes a car without load transfer, relaxation and delays, `car` the values of the vehicle file.
"""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from corner_sim.car.car_parameters import CarParameters, SensorParameters
from corner_sim.car.other_tyres import BRUSH_TYRES, Scaled
from corner_sim.car.pressure_prescription import Cycling
from corner_sim.car.tyre import TYRES
from friction_curve_id.methods import DEFAULT

ROADS = tuple(TYRES["burckhardt"])
BELIEVED: Mapping[str, CarParameters] = MappingProxyType(
    {
        DEFAULT: CarParameters(height=0.0),
        "car": CarParameters(
            relaxation_length=(0.3,) * 4,
            damper_share=0.5,
            pitch_gain=0.0026,
            sensors=SensorParameters(encoder_teeth=48, acceleration_delay=0.005),
        ),
    }
)
"""The car without any trouble, by the method that is judged."""


def _gains(factor: float) -> Mapping[str, Any]:
    gains = CarParameters().brake_gain
    return {"brake_gain": tuple(factor * gain for gain in gains)}


TROUBLES: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "none": {},
        "load transfer": {"height": 0.2 * CarParameters().wheelbase},
        "relaxation 0.05 m": {"relaxation_length": (0.05,) * 4},
        "relaxation 0.3 m": {"relaxation_length": (0.3,) * 4},
        "pressure 10 ms late": {"pressure_delay": 0.01},
        "pressure 20 ms late": {"pressure_delay": 0.02},
        "brake gain -10 %": _gains(0.9),
        "pads fading 20 %": {"fading": 0.2},
        "slope 5 %": {"slope": 0.05},
        "engine drag 100 N m": {"engine_drag": 100.0},
        "wheel stamps 10 ms late": {"wheel_delay": 0.01},
        "48 teeth at 100 Hz": {"encoder_teeth": 48, "sample_rate": 100},
        "Pacejka": {"family": "pacejka"},
        "brush tyres": {"family": "brush"},
        "tyres with load sensitivity 10 %": {"load_sensitivity": 0.1},
        "other tyres at the rear": {"rear": {"friction_factor": 1.06, "slip_factor": 1.1}},
        "load varying 5 % RMS": {"load_variation": 0.05},
        "first rise of 3 s": {"ramp": 3.0},
        "50 Hz": {"sample_rate": 50},
        "1000 Hz": {"sample_rate": 1000},
    }
)
"""Changes to the car, by the name of the trouble; `car` believes in the relaxation length of 0.3 m."""


def troubled_car(trouble: str, road: str, method: str) -> tuple[CarParameters, Cycling]:
    """Make the car of a trouble on a road, for a method of BELIEVED, and the way it is braked."""
    changes = dict(TROUBLES[trouble])
    cycling = Cycling(ramp=changes.pop("ramp", Cycling.ramp))
    tyre = {**TYRES, "brush": BRUSH_TYRES}[changes.pop("family", "burckhardt")][road]
    rear = Scaled(tyre, **changes.pop("rear")) if "rear" in changes else tyre
    believed = BELIEVED[method]
    of_sensors = {name: changes.pop(name) for name in list(changes) if hasattr(SensorParameters, name)}
    sensors = replace(believed.sensors, **of_sensors)
    return replace(believed, tyres=(tyre, tyre, rear, rear), sensors=sensors, **changes), cycling
