"""The two signals of a smart tyre at 10 kHz: wheel encoder and in-tyre accelerometer (sections 8.4.2 and B).

The encoder gives a sine-like voltage with one period a tooth. In the plant the tyres are those of section 8.4 on any
car, the encoders those of the car's wheels.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import signal

from corner_sim.plant import SAMPLE_TIME, PlantSample
from corner_sim.sensors import TYRE_SAMPLE_RATE
from corner_sim.smart_tyre.tyre_ring import TyreRing
from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle import Vehicle, Wheel

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


_JITTERS = 4096
"""Number of edge positions drawn in advance; they repeat after that many revolutions."""


@dataclass(frozen=True)
class AccelerometerParameters:
    """Piezoresistive accelerometer on the inner liner, its radio, and the road that shakes it."""

    bandwidth: float = 3000.0
    """Bandwidth of a second-order low-pass [Hz]."""
    range: float = 500.0 * GRAVITY
    """Saturation, +- [m/s^2]."""
    resolution: float = 1000.0 * GRAVITY / 2**16
    """Resolution of the converter [m/s^2]; 0 for none."""
    texture_noise: float = 4.0 * GRAVITY
    """Shaking by the texture of the road at 20 m/s, standard deviation [m/s^2]; grows with speed to the power 1.5."""
    texture_band: tuple[float, float] = (150.0, 2000.0)
    """[Hz]"""
    electronic_noise: float = 0.3 * GRAVITY
    """White noise, standard deviation [m/s^2]."""
    edge_jitter: float = float(np.radians(0.12))
    """Scatter of each edge of the patch from passage to passage, standard deviation [rad]."""
    offset: float = 2.0 * GRAVITY
    """[m/s^2]"""
    offset_drift: float = 0.05 * GRAVITY
    """[m/s^2 per s]"""
    delay: float = 0.2e-3
    """Delay of the radio [s], rounded up to a whole sample."""
    packet_loss: float = 0.0
    """Probability that a block is lost [-]."""

    @classmethod
    def ideal(cls) -> "AccelerometerParameters":
        """Return a sensor without noise, jitter, offset, drift and loss; bandwidth, delay and converter stay."""
        return cls(texture_noise=0.0, electronic_noise=0.0, edge_jitter=0.0, offset=0.0, offset_drift=0.0)


@dataclass(frozen=True)
class TyreBlock:
    """Consecutive samples of one wheel."""

    first_sample: int
    """Index of the first sample since the source started."""
    encoder_voltage: NDArray[np.float32]
    """[V], shape (n,)."""
    radial_acceleration: NDArray[np.float32]
    """Positive towards the hub [m/s^2], shape (n,)."""
    wheel_angle: Array = field(repr=False)
    """Truth: angle of the hub since the start, forward positive [rad], shape (n,)."""
    lost: bool = False
    """Whether the radio lost this block, so that it never arrives."""


class TyreSignalSource:
    """Makes the signals of one wheel from its motion and forces; keeps phase, filters and noise from call to call."""

    def __init__(
        self,
        ring: TyreRing = TyreRing(),
        accelerometer: AccelerometerParameters = AccelerometerParameters(),
        encoder: EncoderParameters = EncoderParameters(),
        *,
        wheel_seed: int,
        noise_seed: int,
        pressure: float = 2.0e5,
        sample_rate: float = 1.0e4,
    ) -> None:
        """Mount the sensors.

        Args:
            ring: the tyre.
            accelerometer: the sensor in it.
            encoder: the sensor at the hub.
            wheel_seed: seed of the wheel: teeth and mounting angle of the accelerometer.
            noise_seed: seed of the drive: noise, jitter and the angle of the wheel at the start.
            pressure: gauge pressure [Pa].
            sample_rate: sample rate [Hz].
        """
        self._ring, self._accelerometer = ring, accelerometer
        self._toothed_ring = ToothedRing(encoder, wheel_seed)
        self._mounting = float(np.random.default_rng([wheel_seed, 1]).uniform(0.0, 2.0 * np.pi))
        self._rng = np.random.default_rng(noise_seed)
        self.pressure = pressure
        """Gauge pressure [Pa]; may be changed between calls."""
        self._dt = 1.0 / sample_rate
        self._angle = float(self._rng.uniform(0.0, 2.0 * np.pi))
        self._last_speed: float | None = None
        self._next_sample = 0
        self._jitter = accelerometer.edge_jitter * self._rng.standard_normal((_JITTERS, 2))
        band = signal.butter(2, accelerometer.texture_band, "bandpass", fs=sample_rate, output="sos")
        impulse = np.zeros(4096)
        impulse[0] = 1.0
        self._texture_gain = 1.0 / float(np.sqrt(np.sum(signal.sosfilt(band, impulse) ** 2)))
        self._texture_filter, self._texture_state = band, np.zeros((band.shape[0], 2))
        self._sensor_filter = signal.butter(2, accelerometer.bandwidth, fs=sample_rate, output="sos")
        self._sensor_state = np.zeros((1, 2))
        self._radio: Array = np.zeros(round(accelerometer.delay * sample_rate))

    def advance(self, wheel_speed: ArrayLike, fx: ArrayLike, fz: ArrayLike) -> TyreBlock:
        """Return the next n samples.

        Args:
            wheel_speed: wheel speed at the samples [rad/s], shape (n,); negative when rolling back.
            fx: longitudinal force, forward positive [N], broadcasts to (n,).
            fz: vertical load [N], > 0, broadcasts to (n,).
        """
        omega = np.asarray(wheel_speed, dtype=np.float64)
        angle = self._turn(omega)
        speed = np.abs(omega) * self._ring.radius
        acceleration = self._felt(angle, omega, speed, np.asarray(fx), np.asarray(fz))
        delayed = np.concatenate((self._radio, acceleration))
        self._radio = delayed[len(omega) :]
        block = TyreBlock(
            first_sample=self._next_sample,
            encoder_voltage=self._toothed_ring.voltage(angle, omega, self._rng).astype(np.float32),
            radial_acceleration=delayed[: len(omega)].astype(np.float32),
            wheel_angle=angle,
            lost=bool(self._rng.random() < self._accelerometer.packet_loss),
        )
        self._next_sample += len(omega)
        return block

    def _turn(self, omega: Array) -> Array:
        before = np.concatenate(([omega[0] if self._last_speed is None else self._last_speed], omega[:-1]))
        angle = self._angle + np.cumsum(0.5 * (before + omega)) * self._dt
        self._angle, self._last_speed = float(angle[-1]), float(omega[-1])
        return np.asarray(angle)

    def _felt(self, angle: Array, omega: Array, speed: Array, fx: Array, fz: Array) -> Array:
        p = self._accelerometer
        belt = angle - self._mounting - self._ring.patch_shift(fx, fz, self.pressure, speed)
        passage = np.round(belt / (2.0 * np.pi))
        theta = belt - 2.0 * np.pi * passage
        edge = self._ring.patch_half_angle(fz, self.pressure, speed)
        if p.edge_jitter > 0.0:
            edge = edge + self._jitter[passage.astype(np.int64) % _JITTERS, (theta > 0.0).astype(np.int64)]
        felt = omega**2 * self._ring.acceleration_shape(theta, edge) + GRAVITY * np.cos(theta)
        if p.texture_noise > 0.0:
            white = self._rng.standard_normal(len(omega))
            shaking, self._texture_state = signal.sosfilt(self._texture_filter, white, zi=self._texture_state)
            felt = felt + p.texture_noise * self._texture_gain * (speed / 20.0) ** 1.5 * shaking
        felt, self._sensor_state = signal.sosfilt(self._sensor_filter, felt, zi=self._sensor_state)
        seconds = self._dt * (self._next_sample + np.arange(len(omega)))
        felt = felt + p.offset + p.offset_drift * seconds
        if p.electronic_noise > 0.0:
            felt = felt + p.electronic_noise * self._rng.standard_normal(len(omega))
        if p.resolution > 0.0:
            felt = np.round(felt / p.resolution) * p.resolution
        return np.clip(felt, -p.range, p.range)


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
