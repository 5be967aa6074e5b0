"""The methods by the names that messages, parameters and tables use."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from friction_curve_id.banded_normal_equations import MeasurementNoise
from friction_curve_id.curve_fitting import CurveFit, StartParameters, WheelFitting
from friction_curve_id.dead_reckoning import DeadReckoningParameters
from friction_curve_id.default_estimator import DefaultEstimator, DefaultParameters
from friction_curve_id.friction_samples import FrictionSamples, FrictionSource
from friction_curve_id.interface import CurveEstimator, WheelParameters
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


DEFAULT = "default"
METHODS: tuple[str, ...] = (DEFAULT, *CHAPTER_METHODS)
"""All methods that take wheel speed, brake torque and vehicle speed."""
_WHEEL, _START = WheelParameters(), StartParameters()
_GATE, _NOISE = GateParameters(), MeasurementNoise()


def make_estimator(
    name: str,
    wheel: WheelParameters = _WHEEL,
    gate: GateParameters = _GATE,
    noise: MeasurementNoise = _NOISE,
    source: FrictionSource = FrictionSource.DEAD_RECKONED,
    start: StartParameters = _START,
) -> CurveEstimator:
    """Make the estimator of one wheel.

    Args:
        name: one of METHODS.
        wheel: its parameters.
        gate: which samples are admitted.
        noise: of the sensors.
        source: how a method of the chapter makes its friction samples; the default method makes none.
        start: when the fit of a method of the chapter begins.

    Raises:
        ValueError: the name is not one of METHODS.
    """
    if name == DEFAULT:
        return DefaultEstimator(DefaultParameters(wheel=wheel, gate=gate, noise=noise))
    if name not in CHAPTER_METHODS:
        raise ValueError(f"unknown method '{name}': one of {', '.join(METHODS)}")
    dead_reckoning = DeadReckoningParameters(wheel_speed_variance=noise.wheel_speed**2, speed_variance=noise.speed**2)
    return WheelFitting(FrictionSamples(wheel, source, gate, dead_reckoning), CHAPTER_METHODS[name](), start)
