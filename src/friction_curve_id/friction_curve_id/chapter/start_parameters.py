"""Conditions for the start of a fit to friction samples."""

from dataclasses import dataclass

from friction_parameters.parameter import parameter


@dataclass(frozen=True)
class StartParameters:
    """See PointFitting of `curve_fitting`."""

    lambda_init: float = parameter(0.0, "the fit begins beyond this slip", minimum=0.0, maximum=0.5)
    initial_samples: int = parameter(
        20, "minimum number of friction samples before the fit begins", minimum=4, maximum=400
    )
