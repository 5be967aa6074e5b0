"""Parameters of wheel_slip: of the node, the bag runner and the parameter file."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from friction_parameters import shared
from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import group, parameter
from vehicle_models.vehicle_file import moved, vehicle_file_parameter
from wheel_slip.estimator import EstimatorParameters


@dataclass(frozen=True)
class SpeedSensorParameters:
    """How samples of vehicle_velocity are taken."""

    stddev: float = parameter(
        0.5, "noise of vehicle_velocity where the message gives no covariance", unit="m/s", minimum=1e-3, maximum=50.0
    )
    latency: float = parameter(
        0.0, "age of the speed at the stamp of vehicle_velocity", unit="s", minimum=0.0, maximum=0.5
    )
    wait: float = parameter(
        0.02,
        "a sample of vehicle_velocity is used this long after its stamp; no output waits for it",
        unit="s",
        minimum=0.0,
        maximum=0.5,
    )


@dataclass(frozen=True)
class WheelSlipParameters:
    """All of them, with unit and range."""

    vehicle_file: str = vehicle_file_parameter()
    use_imu: bool = parameter(True, "take imu/data and wait for it")
    deadline: float = shared.deadline()
    speed_sensor: SpeedSensorParameters = group(SpeedSensorParameters())
    estimator: EstimatorParameters = group(EstimatorParameters())

    MOVED: ClassVar[Mapping[str, str]] = {
        "wheels": moved("wheels"),
        "radii": moved("radius"),
        "driven_wheels": moved("driven"),
        **{f"imu_{name}": moved(f"accelerometer.{name}") for name in ("axis", "sign", "offset")},
        **{f"speed_{name}": f"it is 'speed_sensor.{name}'" for name in ("stddev", "latency", "wait")},
        "speed_timeout": "it is 'estimator.vehicle_speed.sensor_timeout'",
        **{
            name: f"it is 'estimator.{name}'" for name in ("minimum_speed", "max_gap", "max_slip_stddev", "learn_radii")
        },
        "wheel_speed_stddev": "it is 'estimator.wheel_filter.speed_stddev'",
        "wheel_jerk_density": "it is 'estimator.wheel_filter.jerk_density'",
        **{name: f"it is 'estimator.vehicle_speed.{name}'" for name in ("slip_per_acceleration", "radius_uncertainty")},
        **{
            name: f"it is 'estimator.vehicle_speed.speed_filter.{name}'"
            for name in ("acceleration_stddev", "offset_stddev", "offset_walk", "blind_offset_walk")
        },
        "slide_window": "it is 'estimator.vehicle_speed.slide.window'",
        "slide_threshold": "it is 'estimator.vehicle_speed.slide.threshold'",
        "slide_above": "it is 'estimator.vehicle_speed.slide.slide_above'",
        "roll_below": "it is 'estimator.vehicle_speed.slide.roll_below'",
    }


SHIPPED: Mapping[str, ShippedFile] = {
    "wheel_slip": ShippedFile("One set for every car: cars differ in the vehicle file.", WheelSlipParameters()),
}
