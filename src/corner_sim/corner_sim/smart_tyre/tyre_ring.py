"""Belt of a rolling tyre: contact patch, its shift, and the radial acceleration in the belt (section 8.4.3).

In polar coordinates about the hub, theta from the centre of the contact patch, the belt is r(theta):

    flat patch, |theta| < theta_c:   r = h / cos(theta)
    bulge beside it, u = |theta| - theta_c > 0:   r = R0 - exp(-k u) (w_c cos(k u) + B sin(k u)),

the decaying wave of a ring on an elastic foundation. Depth and slope are continuous at the edge; bending stiffness
keeps the curvature from jumping there and spreads it over a small angle (a Gaussian of deviation `bending_angle`). A
point of the belt that turns at omega is accelerated towards the hub by omega^2 (r - r''): about omega^2 R0 on the free
belt, more on the bulges, nothing on the flat patch. That is the twin spike of Figure 8.16.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtr

from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]

_CORNER = load_vehicle("smart_tyre_car").corner("front_left")
"""Corner on which the tyre of section 8.4 is mounted."""
_STEP = 5e-4
"""Grid of the tabulated wave [rad]; linear interpolation on it is good to 1e-5 of the spike."""


@dataclass(frozen=True)
class TyreRing:
    """One tyre. The defaults give a patch of 25 degrees and shifts of a few degrees, as in section 8.4."""

    radius: float = _CORNER.radius
    """Radius R0 of the free belt [m]."""
    half_patch: float = float(np.radians(12.5))
    """Half angle theta_c of the patch at static load, nominal pressure and rest [rad]."""
    static_load: float = _CORNER.vertical_load
    """Fz0 [N]."""
    nominal_pressure: float = 2.0e5
    """p0, gauge [Pa]."""
    load_exponent: float = 0.7
    """Exponent of the patch length in (Fz / Fz0) [-]."""
    pressure_exponent: float = -0.3
    """Exponent of the patch length in (effective pressure / p0) [-]."""
    belt_density: float = 12.0
    """Density rho_b [kg/m^2]: centrifugal stiffening adds rho_b v^2 / R0 to the pressure."""
    torsional_stiffness: float = 25.0e3
    """Stiffness k_theta between rim and belt at nominal pressure [N m/rad]."""
    stiffness_pressure_exponent: float = 0.25
    """Exponent of k_theta in (p / p0) [-]."""
    shift_scale: float = 0.15
    """Scale q_s [rad]: the twist q = Fx R0 / k_theta gives a shift q_s tanh(q / q_s), slightly nonlinear."""
    shift_per_speed: float = float(np.radians(0.01))
    """Growth of the shift with speed [rad s/m]."""
    cross_talk: float = 0.08
    """beta of (8.19): a patch longer by 1 rad under load shifts by minus this [rad]."""
    bulge_depth: float = 0.03
    """Depth w_c / R0 at the static patch [-]; proportional to the half angle."""
    bulge_rate: float = 6.2
    """Rate k of the bulge [1/rad]."""
    bending_angle: float = float(np.radians(0.6))
    """Standard deviation of the Gaussian that spreads the change of curvature at the edge [rad]."""

    def patch_half_angle(self, fz: ArrayLike, pressure: ArrayLike, speed: ArrayLike) -> Array:
        """theta_c [rad] under load `fz` [N], gauge `pressure` [Pa] and `speed` [m/s]; the arguments broadcast."""
        effective = np.asarray(pressure) + self.belt_density * np.asarray(speed) ** 2 / self.radius
        return np.asarray(
            self.half_patch
            * (np.asarray(fz) / self.static_load) ** self.load_exponent
            * (effective / self.nominal_pressure) ** self.pressure_exponent
        )

    def patch_shift(self, fx: ArrayLike, fz: ArrayLike, pressure: ArrayLike, speed: ArrayLike) -> Array:
        """Angle of hub rotation by which the belt lags the hub [rad]: positive in traction, negative in braking."""
        stiffness = (
            self.torsional_stiffness
            * (np.asarray(pressure) / self.nominal_pressure) ** self.stiffness_pressure_exponent
        )
        twist = np.asarray(fx) * self.radius / stiffness
        longer = 2.0 * self.half_patch * ((np.asarray(fz) / self.static_load) ** self.load_exponent - 1.0)
        return np.asarray(
            self.shift_scale * np.tanh(twist / self.shift_scale)
            + self.shift_per_speed * np.asarray(speed)
            - self.cross_talk * longer
        )

    def belt_radius(self, theta: ArrayLike, half_angle: ArrayLike) -> Array:
        """r(theta) [m] before bending rounds the edge; |theta| <= pi [rad], broadcasting with the half angle [rad]."""
        theta_, edge = np.asarray(theta, dtype=np.float64), np.asarray(half_angle, dtype=np.float64)
        depth, sine = self._bulge(edge)
        u = np.maximum(np.abs(theta_) - edge, 0.0)
        k = self.bulge_rate
        free = self.radius - np.exp(-k * u) * (depth * np.cos(k * u) + sine * np.sin(k * u))
        flat = self._hub_height(edge) / np.cos(np.minimum(np.abs(theta_), edge))
        return np.where(np.abs(theta_) < edge, flat, free)

    def acceleration_shape(self, theta: ArrayLike, half_angle: ArrayLike) -> Array:
        """r - r'' [m], the radial acceleration towards the hub over omega^2; same arguments as `belt_radius`."""
        theta_, edge = np.asarray(theta, dtype=np.float64), np.asarray(half_angle, dtype=np.float64)
        u = np.abs(theta_) - edge
        depth, sine = self._bulge(edge)
        outside, cosine_wave, sine_wave = _waves(self.bulge_rate, self.bending_angle)
        position = np.clip((u + _margin(self.bending_angle)) / _STEP, 0.0, len(outside) - 1.001)
        cell = position.astype(np.int64)
        fraction = position - cell

        def at(table: Array) -> Array:
            return np.asarray(table[cell] * (1.0 - fraction) + table[cell + 1] * fraction)

        share = at(outside)
        inside = np.clip(np.abs(theta_), 0.0, 1.2 * edge)
        flat = -2.0 * self._hub_height(edge) * np.tan(inside) ** 2 / np.cos(inside)
        return share * self.radius + depth * at(cosine_wave) + sine * at(sine_wave) + (1.0 - share) * flat

    def _bulge(self, edge: Array) -> tuple[Array, Array]:
        """w_c and B of the wave; B from the slope of the flat patch at its edge."""
        depth = self.bulge_depth * self.radius * edge / self.half_patch
        slope = (self.radius - depth) * np.tan(edge)
        return depth, depth - slope / self.bulge_rate

    def _hub_height(self, edge: Array) -> Array:
        return np.asarray((self.radius - self.bulge_depth * self.radius * edge / self.half_patch) * np.cos(edge))


def _margin(bending_angle: float) -> float:
    """Return how far before the edge its rounding begins [rad]."""
    return 6.0 * bending_angle


@lru_cache(maxsize=8)
def _waves(rate: float, bending_angle: float) -> tuple[Array, Array, Array]:
    """Contributions of the free belt and the two waves of the bulge to r - r'', rounded by bending, -margin to pi."""
    margin = _margin(bending_angle)
    u = np.arange(-margin, np.pi + 2.0 * margin, _STEP)
    decay = np.where(u > 0.0, np.exp(-rate * np.maximum(u, 0.0)), 0.0)
    cosine, sine = np.cos(rate * u), np.sin(rate * u)
    cosine_wave = decay * (-cosine + 2.0 * rate**2 * sine)
    sine_wave = decay * (-sine - 2.0 * rate**2 * cosine)
    count = round(margin / _STEP)
    reach = _STEP * np.arange(-count, count + 2) - 0.5 * _STEP
    kernel = np.diff(ndtr(reach / bending_angle))

    def rounded(wave: Array) -> Array:
        return np.asarray(np.convolve(wave, kernel, mode="same"))

    return ndtr(u / bending_angle), rounded(cosine_wave), rounded(sine_wave)
