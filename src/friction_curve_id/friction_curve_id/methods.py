"""The methods, by their names in messages, parameters and tables."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from friction_curve_id.chapter.curve_fitting import CurveFit, WheelFitting
from friction_curve_id.chapter.friction_samples import FrictionSamples, FrictionSource
from friction_curve_id.chapter.least_squares import LeastSquares, RecursiveLS
from friction_curve_id.chapter.maximum_likelihood import MaximumLikelihood
from friction_curve_id.chapter.recursive_ml import RecursiveML, RecursiveMLWithBatch
from friction_curve_id.chapter.start_parameters import StartParameters
from friction_curve_id.interface import CurveEstimator
from friction_curve_id.known_car import InexactVehicle, not_known
from friction_curve_id.measurement_noise import MeasurementNoise
from friction_curve_id.sample_gate import GateParameters
from friction_parameters.parameter import parameter
from vehicle_models.vehicle import CornerParameters, Vehicle

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


@dataclass(frozen=True)
class ChapterParameters(StartParameters):
    """When a fit of the chapter's methods begins, and which samples it uses."""

    friction_source: str = parameter(
        FrictionSource.DEAD_RECKONED.value,
        "equation of the friction samples",
        choices=tuple(source.value for source in FrictionSource),
    )


_GATE, _NOISE, _START = GateParameters(), MeasurementNoise(), StartParameters()


def make_estimator(
    name: str,
    vehicle: Vehicle,
    wheel: str,
    gate: GateParameters = _GATE,
    noise: MeasurementNoise = _NOISE,
    source: FrictionSource = FrictionSource.DEAD_RECKONED,
    start: StartParameters = _START,
) -> CurveEstimator:
    """Make the estimator of one wheel. Its curves are valid only where the vehicle is known exactly.

    Args:
        name: one of CHAPTER_METHODS.
        vehicle: the car.
        wheel: name of the wheel.
        gate: which samples are admitted.
        noise: noise of the sensors.
        source: how the friction samples are made.
        start: when the fit begins.

    Raises:
        ValueError: the name is not one of CHAPTER_METHODS.
    """
    estimator = exact_wheel_estimator(name, vehicle.corner(wheel), gate, noise, source, start)
    unknown = not_known(vehicle)
    return InexactVehicle(estimator, unknown) if unknown else estimator


def exact_wheel_estimator(
    name: str,
    wheel: CornerParameters,
    gate: GateParameters = _GATE,
    noise: MeasurementNoise = _NOISE,
    source: FrictionSource = FrictionSource.DEAD_RECKONED,
    start: StartParameters = _START,
) -> CurveEstimator:
    """Make the estimator of a wheel that is known exactly, as in a simulation; arguments as for make_estimator."""
    if name not in CHAPTER_METHODS:
        raise ValueError(f"unknown method '{name}': one of {', '.join(CHAPTER_METHODS)}")
    return WheelFitting(FrictionSamples(wheel, source, gate, noise), CHAPTER_METHODS[name](), start)
