"""Parameters of friction_curve_id: of the node, the bag runner and the parameter file."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from friction_curve_id.car.parameters import CarEstimatorParameters
from friction_curve_id.chapter.friction_samples import FrictionSource
from friction_curve_id.chapter.tyre_force import TyreForceParameters
from friction_curve_id.interface import CurveEstimator
from friction_curve_id.measurement_noise import MeasurementNoise
from friction_curve_id.methods import CHAPTER_METHODS, ChapterParameters, make_estimator
from friction_curve_id.sample_gate import GateParameters
from friction_curve_id.vehicle.vehicle_samples import WholeVehicleParameters
from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import constant, constants, deadline_parameter, group, parameter
from vehicle_models.physical_bounds import HIGHEST_MU
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import vehicle_file_parameter

AUTO, CAR, VEHICLE, TYRE_FORCE = "auto", "car", "vehicle", "tyre_force"
SLIP, VEHICLE_VELOCITY, NO_SPEED = "slip", "vehicle_velocity", "none"


@dataclass(frozen=True)
class FrictionCurveParameters:
    """All of them, with unit and range; the car is in the vehicle file."""

    vehicle_file: str = vehicle_file_parameter()
    method: str = parameter(
        AUTO,
        "identification method; auto: car, or vehicle on a drive without brake pressures",
        choices=(AUTO, CAR, VEHICLE, *CHAPTER_METHODS, TYRE_FORCE),
    )
    speed_source: str = parameter(
        SLIP,
        "source of the vehicle speed: the topic <wheel>/slip, vehicle_velocity, or none",
        choices=(SLIP, VEHICLE_VELOCITY, NO_SPEED),
    )
    abs_activation_slip: float = parameter(
        0.15, "slip that marks the ABS activation of a braking", minimum=0.01, maximum=0.9
    )
    highest_mu: float = constant(HIGHEST_MU, "a larger mu_max is never valid")
    deadline: float = deadline_parameter()
    gate: GateParameters = group(GateParameters(), selector="method", methods=tuple(CHAPTER_METHODS))
    noise: MeasurementNoise = group(MeasurementNoise(), selector="method", methods=tuple(CHAPTER_METHODS))
    chapter: ChapterParameters = group(ChapterParameters(), selector="method", methods=tuple(CHAPTER_METHODS))
    car: CarEstimatorParameters = group(CarEstimatorParameters(), selector="method", methods=(AUTO, CAR))
    vehicle: WholeVehicleParameters = group(WholeVehicleParameters(), selector="method", methods=(VEHICLE,))
    tyre_force: TyreForceParameters = constants(TyreForceParameters())

    def __post_init__(self) -> None:
        """Refuse combinations that cannot work."""
        if self.method == VEHICLE and self.speed_source == NO_SPEED:
            raise ValueError("parameter 'speed_source' = 'none' does not serve the method 'vehicle'")

    def without_pressure(self) -> "FrictionCurveParameters":
        """Return the parameters for a drive without brake pressures: AUTO stands for the method VEHICLE there."""
        is_open = self.method == AUTO and self.speed_source != NO_SPEED
        return replace(self, method=VEHICLE) if is_open else self

    def estimator(self, vehicle: Vehicle, wheel: str) -> CurveEstimator:
        """Make the estimator of one wheel by the method, one of CHAPTER_METHODS."""
        source = FrictionSource(self.chapter.friction_source)
        return make_estimator(self.method, vehicle, wheel, self.gate, self.noise, source, self.chapter)


SHIPPED: Mapping[str, ShippedFile] = {
    "friction_curve_id": ShippedFile(
        "All parameters but vehicle_file may be changed live; the fits then start again.",
        FrictionCurveParameters(),
    )
}
