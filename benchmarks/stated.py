"""Record of an answer of a curve estimator."""

from friction_curve_id.interface import CurveEstimate

STATED = (
    "lambda_max",
    "lambda_max_stddev",
    "mu_max",
    "mu_max_stddev",
    "probability_beyond_peak",
    "valid",
    "restarted",
)
"""Values of an estimate; flags are 0 or 1."""


def stated(answer: CurveEstimate) -> list[float]:
    """Return the values STATED of an estimate."""
    return [float(getattr(answer, name)) for name in STATED]
