"""Parameters of friction_slope: of the node, the bag runner and the parameter files."""

from collections.abc import Mapping
from dataclasses import dataclass

from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import constants, deadline_parameter, group, parameter
from friction_slope.detector import DetectorParameters, NoSlipParameters
from friction_slope.estimate import Method
from friction_slope.vote import VoteTuning
from vehicle_models.vehicle_file import vehicle_file_parameter


@dataclass(frozen=True)
class FrictionSlopeParameters:
    """Parameters of the node."""

    vehicle_file: str = vehicle_file_parameter()
    method: str = parameter(
        Method.SLIP_POSITION.value,
        "where the slip stands on the curve; or by the sign of the slip rate: measured (8.4), or of eta (8.5)",
        choices=tuple(method.value for method in Method),
    )
    detector: DetectorParameters = group(DetectorParameters())
    no_slip: NoSlipParameters = group(NoSlipParameters())
    vote: VoteTuning = constants(VoteTuning())
    deadline: float = deadline_parameter(0.03)

    @property
    def takes_slip(self) -> bool:
        """Whether <wheel>/slip is an input."""
        return self.method != "no_slip" or self.no_slip.slip_at_crossing


SHIPPED: Mapping[str, ShippedFile] = {
    "friction_slope": ShippedFile(
        "One set for both methods and all roads.",
        FrictionSlopeParameters(),
    ),
}
