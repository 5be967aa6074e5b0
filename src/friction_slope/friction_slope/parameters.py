"""Parameters of friction_slope: of the node, the bag runner and the parameter files."""

from collections.abc import Mapping
from dataclasses import dataclass

from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import deadline_parameter, group, parameter
from friction_slope.detector import DetectorParameters, NoSlipParameters
from friction_slope.estimate import Method
from friction_slope.vote import VoteParameters
from vehicle_models.vehicle_file import vehicle_file_parameter


@dataclass(frozen=True)
class FrictionSlopeParameters:
    """All of them, with unit and range."""

    vehicle_file: str = vehicle_file_parameter()
    method: str = parameter(
        "slip",
        "sign of the slip rate: measured (8.4), and where the slip is lost as with no_slip; or that of eta (8.5)",
        choices=tuple(method.value for method in Method),
    )
    detector: DetectorParameters = group(DetectorParameters())
    no_slip: NoSlipParameters = group(NoSlipParameters())
    vote: VoteParameters = group(VoteParameters())
    deadline: float = deadline_parameter(0.03)

    def __post_init__(self) -> None:
        """Refuse a prediction as an estimate: a file from before the vote had its own group tunes the vote with it."""
        if self.detector.lead > 1.0:
            raise ValueError(
                f"parameter 'detector.lead' = {self.detector.lead} is above 1: an estimate is not predicted. The vote "
                "for abs_supervisor is; what tunes it belongs into the group 'vote': 'vote.window', 'vote.lead', ..."
            )

    @property
    def takes_slip(self) -> bool:
        """Whether <wheel>/slip is an input."""
        return self.method == "slip" or self.no_slip.slip_at_crossing


SHIPPED: Mapping[str, ShippedFile] = {
    "friction_slope": ShippedFile(
        "One set for both methods and all roads. `vote` tunes <wheel>/slope_vote, the fast vote for abs_supervisor.",
        FrictionSlopeParameters(),
    ),
}
