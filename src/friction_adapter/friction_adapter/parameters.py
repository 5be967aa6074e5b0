"""Parameters of friction_adapter: of the node and the parameter file."""

from collections.abc import Mapping
from dataclasses import dataclass

from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import parameter
from vehicle_models.vehicle_file import vehicle_file_parameter


@dataclass(frozen=True)
class FrictionAdapterParameters:
    """All of them."""

    vehicle_file: str = vehicle_file_parameter()
    map_file: str = parameter("", "the signal map: path, or the name of a shipped one", read_only=True)


SHIPPED: Mapping[str, ShippedFile] = {
    "friction_adapter": ShippedFile(
        "Cars differ in the signal map and in the vehicle file.", FrictionAdapterParameters()
    )
}
