"""Tuning of the fast slope indicator for the machine of Figure 8.1: the same detector, early and noisy."""

from dataclasses import dataclass, replace

from friction_parameters.parameter import constant
from friction_slope.detector import DetectorParameters, NoSlipParameters


@dataclass(frozen=True)
class VoteTuning:
    """What the vote, which is by (8.5), does not share with the estimate."""

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
