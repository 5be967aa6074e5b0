"""The two signals of a smart tyre at 10 kHz: wheel encoder and in-tyre accelerometer (section 8.4.2)."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import signal

from vehicle_models.constants import GRAVITY
from vehicle_models.encoder import EncoderParameters, ToothedRing
from vehicle_models.tyre_ring import TyreRing

Array = NDArray[np.float64]
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
