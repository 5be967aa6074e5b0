"""When a fit to friction samples begins and ends."""

from dataclasses import dataclass

from friction_parameters.parameter import parameter


@dataclass(frozen=True)
class StartParameters:
    """See PointFitting of `curve_fitting`."""

    lambda_init: float = parameter(0.0, "the fit begins beyond this slip", minimum=0.0, maximum=0.5)
    initial_samples: int = parameter(20, "and with so many friction samples", minimum=4, maximum=400)
    min_slip_span: float = parameter(
        0.003, "they must spread over this much slip, or there is nothing to fit", minimum=1e-5, maximum=0.1
    )
    release_time: float = parameter(
        0.5, "a brake released for longer than this ends the fit", unit="s", minimum=0.01, maximum=10.0
    )
