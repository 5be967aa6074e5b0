"""The friction curve of a car that is not known exactly: one fit for all wheels, with priors of all nuisances."""

from friction_curve_id.car.car_sample import CarSample
from friction_curve_id.car.estimator import CarEstimator
from friction_curve_id.car.parameters import CarEstimatorParameters

__all__ = ["CarEstimator", "CarEstimatorParameters", "CarSample"]
