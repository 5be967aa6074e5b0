"""Measured signals at the nodes between the wheel speeds, from the samples of a braking.

A wheel speed is a mean: from the encoder's last edge before one stamp to the last before the next, so that the node of
samples k and k + 1 is the stamp of k. To third order the speed at the node between the means w_k and w_{k+1} is
(-w_{k-1} + 7 w_k + 7 w_{k+1} - w_{k+2}) / 12. The edges are half a tooth late on average, and up to a tooth at random:
an error in proportion to the wheel's acceleration. A speed that was not counted holds at its stamp: then the nodes lie
half-way between the stamps.

The brake of a locked wheel is a reaction: it holds against the tyre, with less than its pressure would make. A wheel
may stand where it is slower than 0.3 of the car and, if its speed is counted, than one tooth between two samples, or
than its speed changes from or to the next: then it may have stood for part of the time over which it was counted. A
node does not count where such a speed is one of the six about it: a wheel that stands at the end of an interval has
turned on average, and the four pressures of a node reach as far.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from math import pi

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.braking_samples import BrakingSamples
from friction_curve_id.car.car_constants import CarConstants

Array = NDArray[np.float64]

TURNING = 0.3
"""Speed of a wheel over that of the car from which on it surely turns."""
_DEPARTURE, _DEPARTURE_SLIP, _DEPARTURE_TIME = 1.5, 0.07, 0.1
"""Least change of a wheel's speed beside its car's [m/s], and over the car's speed [-], and the time of both [s].

In ordinary driving one of the two is below 0.7 of its limit; a wheel that comes back on snow makes 1.4 of both.
"""
_LEAST_SAMPLING = 1e-4
"""[s]"""
_EITHER_SIDE = (0.025, 0.04, 0.06, 0.09)
"""Times before and after a node over which a yaw rate may be taken for a cubic [s]: cross-validation chooses."""


@dataclass(frozen=True)
class Nodes:
    """Measured signals at n nodes of W wheels."""

    time: Array
    """Since the start of the window's first sample [s], shape (n,)."""
    interval: Array
    """Time between the wheel speeds about the node [s], shape (n,)."""
    wheel_speed: Array
    """At the node [rad/s], shape (W, n)."""
    wheel_acceleration: Array
    """[rad/s^2], shape (W, n)."""
    wheel_noise: Array
    """Standard deviation of the n + 1 wheel speeds about the nodes [rad/s], shape (W, n + 1)."""
    acceleration: Array
    """[m/s^2], shape (n,)."""
    speed_change: Array
    """Integral of the acceleration over `time` [m/s], shape (n,)."""
    acceleration_change: Array
    """Acceleration less that at the start [m/s^2], shape (n,)."""
    start_speed: float
    """Speed of the wheels at time 0 [m/s]."""
    closed: Array
    """1 where the throttle is closed, shape (n,)."""
    turning: NDArray[np.bool_]
    """Whether the wheel turns: the brake of a locked one does not act with its torque. Shape (W, n)."""
    work: Array
    """Work of the brakes at nominal gain [J], shape (W, n)."""
    yaw_rate: Array
    """Counter-clockwise [rad/s], shape (n,); zero where it is not measured."""
    leftward: Array
    """Lateral acceleration [m/s^2], shape (n,)."""
    sideways: Array
    """Integral of leftward - yaw_rate v over `time` [m/s], shape (n,)."""
    rolled: Array
    """Lateral acceleration whose steady load transfer acts [m/s^2], shape (n,)."""
    spread: float
    """Share of its second difference that a torque's mean between the wheel speeds has more than its node [-]."""

    @cached_property
    def sampling(self) -> float:
        """Median time between wheel speeds [s]."""
        return max(float(np.median(self.interval)), _LEAST_SAMPLING)

    def subset(self, nodes: slice) -> "Nodes":
        """Return some neighbouring nodes."""
        first, last = nodes.start or 0, nodes.stop
        return Nodes(
            self.time[nodes],
            self.interval[nodes],
            self.wheel_speed[:, nodes],
            self.wheel_acceleration[:, nodes],
            self.wheel_noise[:, first : None if last is None else last + 1],
            self.acceleration[nodes],
            self.speed_change[nodes],
            self.acceleration_change[nodes],
            self.start_speed,
            self.closed[nodes],
            self.turning[:, nodes],
            self.work[:, nodes],
            self.yaw_rate[nodes],
            self.leftward[nodes],
            self.sideways[nodes],
            self.rolled[nodes],
            self.spread,
        )


@dataclass(frozen=True)
class Start:
    """State of the car at the first sample of the window."""

    time: float
    """Stamp at which the integral of the acceleration began [s]."""
    speed: float
    """Speed of the wheels then [m/s]."""
    acceleration: float
    """[m/s^2]"""
    speed_change: float
    """Integral of the acceleration at `time` [m/s]."""
    sideways: float = 0.0
    """Integral of lateral acceleration less centripetal one at `time` [m/s]."""


def node_signals(car: CarConstants, samples: BrakingSamples, start: Start, wheel_stddev: Array, counted: bool) -> Nodes:
    """Return the signals at the n - 1 nodes of n >= 4 samples.

    Args:
        car: nominal values.
        samples: the samples.
        start: state at the start of the braking.
        wheel_stddev: standard deviation of a speed of a wheel that turns steadily [rad/s], shape (W,).
        counted: whether the speeds come from toothed encoders.
    """
    t, w = samples.time, samples.wheel_speed
    step = np.diff(t)
    if counted:
        time = t[:-1]
        interval = step.copy()
        interval[1:] = 0.5 * (step[1:] + step[:-1])
        acceleration, change, closed = samples.acceleration[:-1], samples.speed_change[:-1], samples.closed[:-1]
        work = samples.work[:, :-1]
        yaw_rate, leftward, rolled = samples.yaw_rate[:-1], samples.leftward[:-1], samples.rolled[:-1]
        sideways = samples.sideways[:-1]
        near, far = 7.0 / 12.0, -1.0 / 12.0
    else:
        time, interval = 0.5 * (t[1:] + t[:-1]), step
        acceleration = 0.5 * (samples.acceleration[1:] + samples.acceleration[:-1])
        change = 0.5 * (samples.speed_change[1:] + samples.speed_change[:-1])
        closed = samples.closed[:-1]
        work = 0.5 * (samples.work[:, 1:] + samples.work[:, :-1])
        yaw_rate = 0.5 * (samples.yaw_rate[1:] + samples.yaw_rate[:-1])
        leftward = 0.5 * (samples.leftward[1:] + samples.leftward[:-1])
        sideways = 0.5 * (samples.sideways[1:] + samples.sideways[:-1])
        rolled = 0.5 * (samples.rolled[1:] + samples.rolled[:-1])
        near, far = 0.5, 0.0
    speed = 0.5 * (w[:, 1:] + w[:, :-1])
    speed[:, 1:-1] = near * (w[:, 1:-2] + w[:, 2:-1]) + far * (w[:, :-3] + w[:, 3:])
    growth = np.diff(w, axis=1) / interval
    velocity = start.speed + samples.speed_change - start.speed_change
    standing = car.radius * w < TURNING * np.maximum(velocity, (car.radius * w).max(axis=0))
    if counted:
        turned = np.abs(np.diff(w, axis=1))
        least = np.maximum(turned, 2.0 * pi / (car.teeth * step))
        least[:, :-1] = np.maximum(least[:, :-1], turned[:, 1:])
        standing[:, 1:] &= w[:, 1:] < least
    noise = np.empty_like(w)
    noise[:] = wheel_stddev[:, np.newaxis] ** 2
    if counted:
        tooth = (2.0 * pi) / (car.teeth * np.maximum(speed, 1.0))
        late = growth * tooth
        speed += 0.5 * late
        # Where teeth come more slowly than samples, a speed is held, or the mean over a longer time than it should be.
        held = np.maximum(tooth - 0.7 * interval, 0.0)
        random = growth**2 * tooth**2 / 24.0 + (_largest_around(growth) * held) ** 2
        noise[:, :-1] += random
        noise[:, 1:] = np.maximum(noise[:, 1:], noise[:, 1:] + random - noise[:, :-1])
    return Nodes(
        time - start.time,
        interval,
        speed,
        growth,
        np.sqrt(noise),
        acceleration,
        change - start.speed_change,
        acceleration - start.acceleration,
        start.speed,
        closed,
        ~_near(standing),
        work,
        yaw_rate,
        leftward,
        sideways - start.sideways,
        rolled,
        1.0 / 6.0 if counted else 1.0 / 24.0,
    )


def delayed(samples: BrakingSamples, nodes: Nodes, start: Start, delay: float) -> tuple[Array, Array]:
    """Return the torques that act between the wheel speeds about the nodes [N m], and their derivative [N m/s].

    A torque is older than its stamp by `delay` [s]: that of a node is stamped later. For torques that run straight
    between their samples, the mean by the triangle over both intervals is a cubic B-spline at any delay. Interpolated
    values would have less noise half-way between the samples than at them, and the fit of the delay would go there.
    Beyond the newest a torque is held. Shapes (W, n).
    """
    t = samples.time
    last = t.size - 1
    place = np.interp(nodes.time + (start.time + delay), t, np.arange(t.size, dtype=np.float64))
    before = np.minimum(place.astype(np.int64), last - 1)
    f = place - before
    g = 1.0 - f
    at = np.clip(before + np.arange(-1, 3)[:, np.newaxis], 0, last)
    weights = np.array([g**3, 4.0 - 6.0 * f**2 + 3.0 * f**3, 4.0 - 6.0 * g**2 + 3.0 * g**3, f**3]) * (1.0 / 6.0)
    rates = np.array([-0.5 * g**2, -2.0 * f + 1.5 * f**2, 2.0 * g - 1.5 * g**2, 0.5 * f**2])
    rates /= t[before + 1] - t[before]
    near = samples.torque[:, at]
    return np.einsum("wkn,kn->wn", near, weights), np.einsum("wkn,kn->wn", near, rates)


def departs(car: CarConstants, nodes: Nodes) -> bool:
    """Whether the speed of a wheel that turns changes beside that of its car as only a wheel beyond its peak does.

    What friction loses there goes into the wheel, and back when the brake is released. A driver's pedal makes less.
    """
    size = max(round(_DEPARTURE_TIME / nodes.sampling), 1)
    beside = car.radius * nodes.wheel_speed - nodes.speed_change
    turning = nodes.turning[:, size:] & nodes.turning[:, :-size]
    least = np.maximum(_DEPARTURE, _DEPARTURE_SLIP * (nodes.start_speed + nodes.speed_change[size:]))
    return bool((turning & (np.abs(beside[:, size:] - beside[:, :-size]) > least)).any())


def turning_beside_brakes(nodes: Nodes, moment: Array) -> Array:
    """Return yaw acceleration less what a moment over the yaw inertia makes of it [rad/s^2], shape (n,).

    Lateral forces turn the car more smoothly than brakes do, so that their share survives where noise does not.

    Args:
        nodes: measured signals.
        moment: of the brakes over the yaw inertia [rad/s^2], shape (n,).
    """
    turned = nodes.yaw_rate.copy()
    turned[1:] -= np.cumsum(0.5 * (moment[1:] + moment[:-1]) * np.diff(nodes.time))
    n, interval = turned.size, nodes.sampling
    half = (n - 1) // 2
    if half > 1:
        halves = {max(min(round(each / interval), n // 4), 2) for each in _EITHER_SIDE}
        half = min(halves, key=lambda each: _missed(turned, each, max(halves)))
    slopes = _cubics(2 * half + 1)[1]
    result = np.empty_like(turned)
    result[: half + 1] = slopes[: half + 1] @ turned[: 2 * half + 1]
    result[half : n - half] = np.convolve(turned, slopes[half, ::-1], "valid")
    result[n - half :] = slopes[half + 1 :] @ turned[n - 2 * half - 1 :]
    return result / interval


def _missed(values: Array, half: int, margin: int) -> float:
    """Return by how much cubics through `half` values on either side miss others, by generalised cross-validation."""
    weights = _cubics(2 * half + 1)[0][half]
    missed = (values[half : values.size - half] - np.convolve(values, weights[::-1], "valid"))[margin - half :]
    return float(np.mean(missed[: values.size - 2 * margin] ** 2)) / (1.0 - float(weights[half])) ** 2


@cache
def _cubics(size: int) -> tuple[Array, Array]:
    """Return weights of neighbouring values: value and slope at each of the cubic nearest to them, (size, size)."""
    place, power = np.arange(size)[:, np.newaxis] - 0.5 * (size - 1), np.arange(min(4, size))
    values = place**power
    nearest = np.linalg.pinv(values)
    return np.asarray(values @ nearest), np.asarray((power * place ** np.maximum(power - 1, 0)) @ nearest)


def _near(standing: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Nodes that have a marked sample among the three on either side; shapes (W, n) and (W, n - 1)."""
    wheels, n = standing.shape
    padded = np.zeros((wheels, n + 4), dtype=bool)
    padded[:, 2:-2] = standing
    near = padded[:, : n - 1]
    for k in range(1, 6):
        near = near | padded[:, k : k + n - 1]
    return near


def with_repeated_ends(values: Array) -> Array:
    """Return the values, shape (W, n), with the first and the last of each row twice more, shape (W, n + 4).

    numpy's pad took most of the time of its callers.
    """
    rows, n = values.shape
    padded = np.empty((rows, n + 4))
    padded[:, 2:-2] = values
    padded[:, :2] = values[:, :1]
    padded[:, -2:] = values[:, -1:]
    return padded


def _largest_around(values: Array) -> Array:
    """Return the largest size of each value and its two neighbours on either side, shape (W, n)."""
    padded = np.abs(with_repeated_ends(values))
    n = values.shape[1]
    largest = padded[:, :n]
    for k in range(1, 5):
        largest = np.maximum(largest, padded[:, k : k + n])
    return largest
