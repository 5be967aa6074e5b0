"""Parameters of friction_grip: of the node, the bag runner and the parameter file."""

from collections.abc import Mapping
from dataclasses import dataclass

from friction_grip.road_prior import RoadPrior
from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import deadline_parameter, group, parameter
from vehicle_models.vehicle_file import vehicle_file_parameter


@dataclass(frozen=True)
class FrictionGripParameters:
    """All of them, with unit and range."""

    vehicle_file: str = vehicle_file_parameter()
    deadline: float = deadline_parameter(0.1)
    change_distance: float = parameter(
        300.0, "mean distance between changes of the road", unit="m", minimum=5.0, maximum=1e5
    )
    proof_distance: float = parameter(
        100.0, "distance over which the largest proof is kept", unit="m", minimum=1.0, maximum=1e4
    )
    lower_probability: float = parameter(0.95, "probability that mu_lower claims", minimum=0.5, maximum=0.999)
    prior: RoadPrior = group(RoadPrior())


SHIPPED: Mapping[str, ShippedFile] = {
    "friction_grip": ShippedFile(
        "Friction used, proven and left; the prior is that of a year.", FrictionGripParameters()
    ),
}
