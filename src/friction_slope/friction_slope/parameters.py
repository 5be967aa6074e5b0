"""Parameters of friction_slope: of the node, the bag runner and the parameter files."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import constant, constants, deadline_parameter, group, parameter
from friction_slope.detector import DetectorParameters, NoSlipParameters
from friction_slope.estimate import Method
from vehicle_models.vehicle_file import vehicle_file_parameter


@dataclass(frozen=True)
class VoteTuning:
    """Tuning of the fast slope indicator for the machine of Figure 8.1: the detector by (8.5), early and noisy."""

    window: int = constant(6, "samples of the fit that gives H")
    lead: float = constant(2.85, "where H is read: 0 window's centre, 1 newest sample, above 1 ahead of it")
    rate_window: int = constant(3, "samples of the fit that gives eta")
    h_instability: float = constant(-1.0, "indicator at or below which stability is lost", unit="rad/s^3")
    h_stability: float = constant(8000.0, "indicator at or above which stability is regained", unit="rad/s^3")
    slip_rate_dead_zone: float = constant(0.8, "slip rates up to this count for nothing", unit="1/s")
    eta_margin: float = constant(0.3, "margin of eta above the deceleration of the car, and below 0, for a sign")

    @property
    def no_slip(self) -> NoSlipParameters:
        """Parameters of (8.5)."""
        return NoSlipParameters(eta_margin=self.eta_margin)

    def detector(self, estimate: DetectorParameters) -> DetectorParameters:
        """Return the parameters of the vote's detector: six samples show no scatter, nor a change of load."""
        return replace(
            estimate,
            window=self.window,
            lead=self.lead,
            rate_window=self.rate_window,
            h_instability=self.h_instability,
            h_stability=self.h_stability,
            slip_rate_dead_zone=self.slip_rate_dead_zone,
            least_growth=0.0,
            load_transfer=False,
        )


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
