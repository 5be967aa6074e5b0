"""Parameters of wheel_slip: of the node, the bag runner and the parameter file."""

from collections.abc import Mapping
from dataclasses import dataclass

from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import deadline_parameter, group, parameter
from vehicle_models.vehicle_file import vehicle_file_parameter
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


@dataclass(frozen=True)
class WheelSlipParameters:
    """Parameters of the node."""

    vehicle_file: str = vehicle_file_parameter()
    use_imu: bool = parameter(True, "use imu/data and wait for it")
    deadline: float = deadline_parameter()
    speed_sensor: SpeedSensorParameters = group(SpeedSensorParameters())
    estimator: EstimatorParameters = group(EstimatorParameters())


SHIPPED: Mapping[str, ShippedFile] = {
    "wheel_slip": ShippedFile("One set for every car: cars differ in the vehicle file.", WheelSlipParameters()),
}
