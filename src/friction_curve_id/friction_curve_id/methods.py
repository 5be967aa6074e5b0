"""The methods by the names that messages, parameters and tables use."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from friction_curve_id.curve_fitting import CurveFit, StartParameters, WheelFitting
from friction_curve_id.dead_reckoning import DeadReckoningParameters
from friction_curve_id.friction_samples import FrictionSamples, FrictionSource
from friction_curve_id.interface import WheelParameters
from friction_curve_id.least_squares import LeastSquares
from friction_curve_id.maximum_likelihood import MaximumLikelihood
from friction_curve_id.recursive_ls import RecursiveLS
from friction_curve_id.recursive_ml import RecursiveML, RecursiveMLWithBatch
from friction_curve_id.sample_gate import GateParameters

CHAPTER_METHODS: Mapping[str, Callable[[], CurveFit]] = MappingProxyType(
    {
        "ml": MaximumLikelihood,
        "rml": RecursiveML,
        "rml_ml": RecursiveMLWithBatch,
        "ls": LeastSquares,
        "rls": RecursiveLS,
    }
)
"""Methods of section 8.3 on friction samples."""


_WHEEL, _START = WheelParameters(), StartParameters()
_GATE, _DEAD_RECKONING = GateParameters(), DeadReckoningParameters()


def chapter_method(
    name: str,
    wheel: WheelParameters = _WHEEL,
    source: FrictionSource = FrictionSource.DEAD_RECKONED,
    start: StartParameters = _START,
    gate: GateParameters = _GATE,
    dead_reckoning: DeadReckoningParameters = _DEAD_RECKONING,
) -> WheelFitting:
    """Make the estimator of one wheel by a method of the chapter.

    Args:
        name: one of CHAPTER_METHODS.
        wheel: its parameters.
        source: how friction samples are made.
        start: when a fit begins.
        gate: which samples are admitted.
        dead_reckoning: for the source DEAD_RECKONED.

    Raises:
        ValueError: the name is not one of CHAPTER_METHODS.
    """
    if name not in CHAPTER_METHODS:
        raise ValueError(f"unknown method '{name}': one of {', '.join(CHAPTER_METHODS)}")
    return WheelFitting(FrictionSamples(wheel, source, gate, dead_reckoning), CHAPTER_METHODS[name](), start)
