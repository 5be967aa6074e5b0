"""Random cars: drawn around the nominal one with all perturbations at once."""

from dataclasses import dataclass

import numpy as np

from corner_sim.car.car_parameters import PITCH_GAIN, CarParameters, SensorParameters
from corner_sim.car.driving import Cycling
from corner_sim.car.tyres import TYRES


@dataclass(frozen=True)
class RandomCar:
    """A car and the way it is braked."""

    parameters: CarParameters
    cycling: Cycling
    family: str
    """Family of its tyres, a key of TYRES."""


def random_car(seed: int, road: str, family: str) -> RandomCar:
    """Draw a car.

    Uniform: brake gain +-10 % of front and rear apart, mass and inertia +-15 %, radius +-1 % of all wheels (each
    differs from that by 0.05 % RMS), height of the centre of gravity +-10 %, load share +-0.02, pressure 0-20 ms and
    accelerometer 0-10 ms late, relaxation 0.05-0.4 m, load varying 0-6 % RMS, slope +-4 %, engine drag 0-80 N m at each
    driven wheel, accelerometer bias +-0.3 m/s^2, scale +-2 %; pitch 0.15 deg per m/s^2 at 1.3-1.9 Hz, damping
    0.35-0.65, any share of the dampers in the load transfer; 48 teeth at 100 or 200 Hz; first rise of pressure 0.15-1 s
    (uniform in its logarithm), reversed at 1.5-2 lambda_max.

    Args:
        seed: same seed, same car; cars of equal seed on different roads or tyres are otherwise equal.
        road: a road of TYRES.
        family: a family of TYRES.

    Raises:
        KeyError: there is no such road or family.
    """
    rng = np.random.default_rng([seed, 2])
    nominal = CarParameters()

    def within(share: float) -> float:
        return float(rng.uniform(1.0 - share, 1.0 + share))

    def between(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    gain = (within(0.1), within(0.1))
    radius = within(0.01)
    radii = [0.3 * radius * (1.0 + each) for each in rng.normal(0.0, 5e-4, 4).tolist()]
    sensors = SensorParameters(
        sample_rate=int(rng.choice([100, 200])),
        encoder_teeth=48,
        pressure_delay=between(0.0, 0.02),
        acceleration_delay=between(0.0, 0.01),
        acceleration_bias=between(-0.3, 0.3),
        acceleration_scale=within(0.02),
    )
    parameters = CarParameters(
        tyres=(TYRES[family][road],) * 4,
        mass=nominal.mass * within(0.15),
        front_load_share=nominal.front_load_share + between(-0.02, 0.02),
        height=nominal.height * within(0.1),
        radius=(radii[0], radii[1], radii[2], radii[3]),
        inertia=(nominal.inertia[0] * within(0.15),) * 4,
        brake_gain=(1.3e-4 * gain[0], 1.3e-4 * gain[0], 0.7e-4 * gain[1], 0.7e-4 * gain[1]),
        engine_drag=between(0.0, 80.0),
        relaxation_length=(between(0.05, 0.4),) * 4,
        pitch_frequency=between(1.3, 1.9),
        pitch_damping=between(0.35, 0.65),
        damper_share=between(0.0, 1.0),
        pitch_gain=PITCH_GAIN,
        load_variation=between(0.0, 0.06),
        slope=between(-0.04, 0.04),
        sensors=sensors,
    )
    ramp = float(np.exp(rng.uniform(np.log(0.15), np.log(1.0))))
    return RandomCar(parameters, Cycling(ramp=ramp, upper=between(1.5, 2.0)), family)
