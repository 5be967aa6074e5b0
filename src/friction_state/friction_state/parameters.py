"""Parameters of friction_state: of the node, the bag runner and the parameter file."""

from collections.abc import Mapping
from dataclasses import dataclass

from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import deadline_parameter, parameter
from vehicle_models.vehicle_file import vehicle_file_parameter


@dataclass(frozen=True)
class FrictionStateParameters:
    """All of them, with unit and range."""

    vehicle_file: str = vehicle_file_parameter()
    deadline: float = deadline_parameter(0.05)
    hold: float = parameter(
        0.5, "age up to which the last friction curve and tyre forces count", unit="s", minimum=0.0, maximum=5.0
    )
    publish_markers: bool = parameter(False, "publish force_markers beside friction_state")


SHIPPED: Mapping[str, ShippedFile] = {
    "friction_state": ShippedFile("All wheels in one message, for plots and logs.", FrictionStateParameters()),
}
