"""Parameters of the car's estimator."""

from collections.abc import Mapping
from dataclasses import dataclass

from friction_curve_id.car.curve_family import PUBLISHED_ROADS, SHAPE_PRIORS, Family, ShapePrior
from friction_parameters.parameter import constant, minimum_speed_parameter, parameter

ANY = "any"


@dataclass(frozen=True)
class CarEstimatorParameters:
    """What the vehicle file does not say."""

    family: str = parameter(
        ANY,
        "tyre model; any: Burckhardt and Pacejka, weighted by evidence",
        choices=(ANY, Family.BURCKHARDT.value),
    )
    wheel_speed_is_interval_mean: bool = parameter(
        True, "wheel speeds are means over the interval between two stamps (encoder edges), not values at the stamp"
    )
    slope_stddev: float = parameter(
        0.023, "standard deviation of the slope of the road; 0: level", minimum=0.0, maximum=0.3
    )
    torque_stddev: float = constant(5.0, "standard deviation of what the wheel equation leaves out", unit="N m")
    minimum_speed: float = minimum_speed_parameter(3.0)
    max_gap: float = constant(0.05, "longest time between two samples of an input that is bridged", unit="s")

    def families(self) -> Mapping[Family, ShapePrior]:
        """Formulas to fit, each with the prior of its shape."""
        return SHAPE_PRIORS if self.family == ANY else {Family.BURCKHARDT: PUBLISHED_ROADS}
