"""Inductive wheel encoder: a sine-like voltage with one period a tooth (sections 8.4.2 and B)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vehicle_models.vehicle import Wheel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EncoderParameters:
    """Imperfections of an ABS encoder."""

    teeth: int = Wheel.encoder_teeth
    """Teeth, missing ones included."""
    missing_teeth: int = 0
    """Teeth in a row that are missing: broken off, or the mark of a ring such as 60-2."""
    amplitude_per_speed: float = 0.05
    """Amplitude over wheel speed [V s/rad]: an inductive sensor measures the rate of change of flux."""
    modulation: float = 0.06
    """Amplitude modulation over one revolution [-], from the run-out of the air gap."""
    second_harmonic: float = 0.03
    """Amplitude of the second harmonic over that of the first [-]."""
    eccentricity: float = float(np.radians(0.05))
    """Angle error of an off-centre ring, once per revolution, amplitude [rad]."""
    pitch_error: float = float(np.radians(0.04))
    """Standard deviation of the place of a tooth [rad]."""
    noise: float = 0.010
    """White noise, standard deviation [V]."""
    resolution: float = 20.0 / 2**16
    """Resolution of the converter [V]; 0 for none."""

    @classmethod
    def ideal(cls) -> "EncoderParameters":
        """Return perfect teeth, a pure sine, no noise."""
        return cls(modulation=0.0, second_harmonic=0.0, eccentricity=0.0, pitch_error=0.0, noise=0.0)


class ToothedRing:
    """One ring with its own teeth, and the voltage of the sensor in front of it."""

    def __init__(self, parameters: EncoderParameters, ring_seed: int) -> None:
        """Draw the teeth; the same seed gives the same ring."""
        self._parameters = parameters
        rng = np.random.default_rng(ring_seed)
        errors = parameters.pitch_error * rng.standard_normal(parameters.teeth)
        errors -= errors.mean()
        self._errors = np.append(errors, errors[0])
        self._eccentric_phase, self._harmonic_phase, self._modulation_phase = rng.uniform(0.0, 2.0 * np.pi, 3)

    def pitch(self, angle: ArrayLike) -> Array:
        """How far the teeth run ahead of an ideal ring [rad] at a wheel angle [rad]."""
        turned = np.asarray(angle, dtype=np.float64)
        place = np.mod(turned, 2.0 * np.pi) * (self._parameters.teeth / (2.0 * np.pi))
        tooth = np.minimum(place.astype(np.int64), self._parameters.teeth - 1)
        # A raised cosine from tooth to tooth: the flux changes smoothly.
        blend = 0.5 - 0.5 * np.cos(np.pi * (place - tooth))
        uneven = self._errors[tooth] * (1.0 - blend) + self._errors[tooth + 1] * blend
        return np.asarray(uneven + self._parameters.eccentricity * np.sin(turned + self._eccentric_phase))

    def voltage(self, angle: ArrayLike, wheel_speed: ArrayLike, rng: np.random.Generator) -> Array:
        """Sampled voltage [V] at wheel angles [rad] and wheel speeds [rad/s], shape (n,)."""
        p = self._parameters
        turned = np.asarray(angle, dtype=np.float64)
        phase = p.teeth * (turned + self.pitch(turned))
        amplitude = (
            p.amplitude_per_speed
            * np.asarray(wheel_speed)
            * (1.0 + p.modulation * np.cos(turned + self._modulation_phase))
        )
        volt = amplitude * (np.sin(phase) + p.second_harmonic * np.sin(2.0 * phase + self._harmonic_phase))
        if p.missing_teeth > 0:
            # Without a tooth the flux does not change.
            volt = np.where(np.mod(phase, 2.0 * np.pi * p.teeth) < 2.0 * np.pi * p.missing_teeth, 0.0, volt)
        if p.noise > 0.0:
            volt = volt + p.noise * rng.standard_normal(volt.shape)
        return np.round(volt / p.resolution) * p.resolution if p.resolution > 0.0 else volt
