"""A stop that is recorded once and taken in place of its plant until a command changes it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from corner_sim.plant import Plant, PlantSample
from vehicle_models.brake_actuator import Command

_DRIVERS = (int(Command.NONE), int(Command.INCREASE))
"""Commands under which the pressure is that of the driver: the second moves towards the demand as the first does."""


class RecordedPlant:
    """A plant whose samples are known as long as only the driver brakes. No noise is in them: seeds can share them."""

    def __init__(self, plant: Plant, samples: Sequence[PlantSample]) -> None:
        """Start at the first sample.

        Args:
            plant: at its first sample, advanced by this class from now on.
            samples: of the same plant under the same demand without commands, from the first one on, at least one.
        """
        self._plant, self._samples = plant, samples
        self._demands: list[ArrayLike] = []
        self._recorded = True

    def sample(self) -> PlantSample:
        """Return the true state now."""
        return self._samples[len(self._demands)] if self._recorded else self._plant.sample()

    def advance(self, demand_pressure: ArrayLike, command: ArrayLike) -> None:
        """Advance by one sample; arguments as in Plant.advance."""
        if self._recorded:
            goes_on = len(self._demands) + 1 < len(self._samples)
            if goes_on and all(each in _DRIVERS for each in np.atleast_1d(command).tolist()):
                self._demands.append(demand_pressure)
                return
            for each in self._demands:
                self._plant.advance(each, Command.NONE)
            self._recorded = False
        self._plant.advance(demand_pressure, command)
