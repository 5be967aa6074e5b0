"""Parameters of smart_tyre_forces: of the node, the bag runner, the calibration tool and the parameter file."""

from collections.abc import Mapping
from dataclasses import dataclass

from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import group, parameter
from smart_tyre_forces.correction import ZeroParameters
from smart_tyre_forces.patch_tracker import TrackerParameters
from vehicle_models.vehicle_file import vehicle_file_parameter


@dataclass(frozen=True)
class SmartTyreParameters:
    """Parameters of the node."""

    vehicle_file: str = vehicle_file_parameter()
    calibration_file: str = parameter("", "calibration made by the calibration tool; empty: raw contact patches only")
    front_method: str = parameter(
        "crossing", "crossing of a level, or matched template of the calibration", choices=("crossing", "template")
    )
    restore_steady_force: bool = parameter(
        True, "add to fx the steady drag and rolling part that the speed trend removes"
    )
    publish_wrench: bool = parameter(False, "publish <wheel>/tyre_wrench beside tyre_force")
    tracker: TrackerParameters = group(TrackerParameters())
    zero: ZeroParameters = group(ZeroParameters())

    def __post_init__(self) -> None:
        """Refuse a template without the file that holds it."""
        if self.front_method == "template" and not self.calibration_file:
            raise ValueError("parameter 'front_method' = 'template' needs 'calibration_file'")


SHIPPED: Mapping[str, ShippedFile] = {
    "smart_tyre_forces": ShippedFile(
        "Raw contact patches; forces need 'calibration_file' (for the plant: calibration/plant_tyres.yaml).",
        SmartTyreParameters(),
    ),
}
