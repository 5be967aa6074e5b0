"""The smart tyres of the plant: encoder voltage and in-tyre acceleration at 10 kHz, in blocks of one sample time.

The tyres are those of section 8.4 on any car; the encoders are those of the car's wheels.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from corner_sim.messages import TYRE_SAMPLE_RATE
from corner_sim.plant import SAMPLE_TIME, PlantSample
from vehicle_models.encoder import EncoderParameters
from vehicle_models.tyre_ring import TyreRing
from vehicle_models.tyre_signal import AccelerometerParameters, TyreBlock, TyreSignalSource
from vehicle_models.vehicle import Vehicle

Array = NDArray[np.float64]

_SMALLEST_LOAD = 1.0
"""Load that a wheel keeps when it lifts off [N]: the tyre model has no patch without load."""


class TyreSensors:
    """One instrumented tyre per wheel."""

    def __init__(self, vehicle: Vehicle, noise: bool, inflation_pressure: float, seed: int) -> None:
        """Mount the sensors.

        Args:
            vehicle: the car.
            noise: whether the sensors have imperfections; else they are ideal.
            inflation_pressure: gauge pressure [Pa].
            seed: seed of noise and starting angles; teeth and mounting belong to the wheel and do not depend on it.
        """
        encoder = EncoderParameters() if noise else EncoderParameters.ideal()
        self._sources = [
            TyreSignalSource(
                TyreRing(),
                AccelerometerParameters() if noise else AccelerometerParameters.ideal(),
                replace(encoder, teeth=wheel.encoder_teeth),
                wheel_seed=number,
                noise_seed=seed * 1000 + number,
                pressure=inflation_pressure,
                sample_rate=TYRE_SAMPLE_RATE,
            )
            for number, wheel in enumerate(vehicle.wheels)
        ]
        self._within = np.arange(round(SAMPLE_TIME * TYRE_SAMPLE_RATE)) / (SAMPLE_TIME * TYRE_SAMPLE_RATE)

    def between(self, before: PlantSample, after: PlantSample) -> list[TyreBlock]:
        """Return the blocks of all wheels from `before` (included) to `after` (excluded), states linear in between."""

        def run(begin: Array, end: Array, i: int) -> Array:
            return np.asarray(begin[i] + (end[i] - begin[i]) * self._within)

        fx_before, fx_after = (-sample.vertical_load * sample.friction for sample in (before, after))
        return [
            source.advance(
                run(before.wheel_speed, after.wheel_speed, i),
                run(fx_before, fx_after, i),
                np.maximum(run(before.vertical_load, after.vertical_load, i), _SMALLEST_LOAD),
            )
            for i, source in enumerate(self._sources)
        ]
