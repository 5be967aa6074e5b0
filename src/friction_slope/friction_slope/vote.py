"""Tuning of the fast slope indicator for the machine of Figure 8.1: the same detector, early and noisy."""

from dataclasses import dataclass, replace

from friction_parameters.parameter import parameter
from friction_slope.detector import DetectorParameters, NoSlipParameters


@dataclass(frozen=True)
class VoteParameters:
    """What the vote, which is by (8.5), does not share with the estimate."""

    window: int = parameter(6, "samples of the fit that gives H", minimum=4, maximum=400)
    lead: float = parameter(
        2.85, "where H is read: 0 window's centre, 1 newest sample, above 1 ahead of it", minimum=0.0, maximum=4.0
    )
    rate_window: int = parameter(3, "samples of the fit that gives eta", minimum=2, maximum=400)
    h_instability: float = parameter(
        -1.0, "indicator at or below which stability is lost", unit="rad/s^3", minimum=-1e5, maximum=0.0
    )
    h_stability: float = parameter(
        8000.0, "indicator at or above which stability is regained", unit="rad/s^3", minimum=0.0, maximum=1e5
    )
    slip_rate_dead_zone: float = parameter(
        0.8, "slip rates up to this count for nothing", unit="1/s", minimum=0.0, maximum=100.0
    )
    eta_margin: float = parameter(
        0.3,
        "eta must be this much above the braking of the car, or below 0, to have a sign",
        minimum=0.0,
        maximum=100.0,
    )

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
