"""mu_max of the driven axle where its wheels spin under the engine: starts on snow, wet hills.

The free axle shows the speed of the car, and the accelerometer the force of the driven one, on any slope:

    mu = (a + drag + inertia of the free wheels) / (load of the driven axle over the mass)

A differential gives its wheels equal torques, of which one that gains speed keeps a part, or equal speeds. Fitted is a
curve of either family (curve_family) to the newest seconds, together with what may be wrong of the car (spin_fit). The
slip of the peak is not found: a wheel that spins passes it faster than its tyre responds. Slips and friction are
negative here, mu_max is positive.
"""

from collections import deque
from collections.abc import Mapping
from math import exp, hypot, isfinite, isnan, nan, pi
from statistics import fmean
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from friction_curve_id.car.car_sample import Checked
from friction_curve_id.car.curve_family import Family, ShapePrior
from friction_curve_id.car.prior import DAMPER_SHARE
from friction_curve_id.car.spin_fit import FEWEST, LAMBDA, LEAST_NOISE, MU, NODE, Fit, fit_curve
from friction_curve_id.interface import CurveEstimate
from vehicle_models.constants import GRAVITY
from vehicle_models.lateral_forces import ACROSS
from vehicle_models.reason import Reason
from vehicle_models.vehicle import STATED, Vehicle, absolute_deviation, deviation_of, relative_deviation
from vehicle_models.wheel_forces import PitchMode, coasting_acceleration

Array = NDArray[np.float64]

OFFSET_STDDEV: Final = 0.003
"""[-] radii of front and rear wear apart."""
TIMING_STDDEV: Final = 0.01
"""[s]"""
WINDOW: Final = 4.0
"""[s] for which nodes are kept: what was before may be another road."""
INTERVAL: Final = 0.1
"""[s] between two fits."""
SPINS: Final = 0.03
"""[-] slip from which on a fit is worth its time: no tyre has its peak below."""
LASTS: Final = 0.2
"""[s] after the last fit for which its number is told: where no wheel spins, the road may have become another."""
ROUGH, OFF = 0.12, 0.06
"""[-] of mu_max by which a fit misses nodes, and the newest FEWEST of them in the mean: beyond, the wheels follow no
common curve, or are on another road."""
BEYOND, SURE = 0.1, 4.0
"""[s] for which a wheel has been beyond the peak, by so many standard deviations of ln lambda_max: a driver has his
wheels before the peak for hours, and each fit is another chance to be wrong."""
LARGEST: Final = 0.25
"""[-] standard deviation of ln mu_max that is valid."""
SIDEWAYS: Final = 0.5
"""[-] force across the wheels over that along them, beyond which a node is left out."""
ACROSS_TIME: Final = 0.2
"""[s] over which the lateral acceleration is averaged that the free wheels show."""


class Node(NamedTuple):
    """Means over NODE; arrays of the W driven wheels."""

    slips: Array
    """After the relaxation of the tyre, and its derivatives by LENGTH and TIMING, shape (3, W)."""
    friction: Array
    """Of each wheel [-], shape (W,)."""
    by_bias: float
    """Its derivative by the bias of the accelerometer [s^2/m]."""
    whole: float
    """Friction over its part along the wheels [-]: more than 1 in a curve."""


class Peak(NamedTuple):
    """The families together."""

    log_mu: float
    log_mu_stddev: float
    smooth: bool
    """Whether the curve explains all nodes, the newest too."""
    nodes: int
    beyond: Array
    """Time of each wheel beyond the peak [s], shape (W,)."""


class Traction:
    """mu_max at the driven wheels, one sample of the car at a time, while no brake acts."""

    def __init__(self, vehicle: Vehicle, families: Mapping[Family, ShapePrior], minimum_speed: float) -> None:
        """Take the car, the families of curves, and the speed below which nothing is computed [m/s]."""
        wheels = vehicle.wheels
        self.driven = [k for k, wheel in enumerate(wheels) if wheel.driven]
        """Wheels that are told of, by index: empty where no axle runs free, or none is driven."""
        free = [k for k, wheel in enumerate(wheels) if not wheel.driven]
        axles = {wheels[k].axle for k in self.driven}
        if len(axles) != 1 or not free or axles & {wheels[k].axle for k in free}:
            self.driven = []
            return
        self._vehicle, self._free, self._families, self._minimum_speed = vehicle, free, families, minimum_speed
        self._radii, self._track = np.array(vehicle.radii), vehicle.track
        self._right = np.array([1.0 if wheels[k].side == "right" else -1.0 for k in free])
        mounting, wheel = vehicle.accelerometer, wheels[self.driven[0]]
        self._scale = mounting.scale * (1.0 + GRAVITY * mounting.pitch_gain)
        share = sum(vehicle.load_shares[k] for k in self.driven)
        self._load, self._transfer = GRAVITY * share, -sum(vehicle.transfer_shares[k] for k in self.driven)
        self._spinning = sum(wheels[k].inertia / wheels[k].radius ** 2 for k in free) / vehicle.mass
        self._inertia = len(self.driven) * wheel.inertia / wheel.radius**2 / vehicle.mass
        self._length = wheel.relaxation_length
        self._pitch = PitchMode(vehicle.pitch_frequency, vehicle.pitch_damping)
        self._dampers = DAMPER_SHARE[0] * vehicle.pitch_damping / (pi * vehicle.pitch_frequency)
        """Time by which the dampers move load ahead of the pitch [s]."""
        height = STATED["centre_of_gravity_height"] * vehicle.centre_of_gravity_height
        moved = deviation_of(vehicle.deviations, "centre_of_gravity_height", height) / vehicle.wheelbase
        loaded = hypot(absolute_deviation(vehicle.deviations, "front_load_share"), moved) / share
        pitch = GRAVITY * absolute_deviation(mounting.deviations, "pitch_gain")
        scale = hypot(absolute_deviation(mounting.deviations, "scale"), relative_deviation(wheel, "radius"))
        self._scale_stddev = hypot(loaded, hypot(pitch, scale))
        bias = absolute_deviation(mounting.deviations, "bias")
        length = relative_deviation(wheel, "relaxation_length")
        self._of_car = np.array([OFFSET_STDDEV, bias, length, TIMING_STDDEV])
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        if not self.driven:
            return
        self._last: Checked | None = None
        self._gathered, self._pushed, self._turned = 0.0, 0.0, np.zeros(len(self._radii))
        self._speed, self._across = nan, 0.0
        self._pitch.settle(0.0)
        self._slip, self._by_length, self._rim = np.zeros((3, len(self.driven)))
        self._forget()

    def _forget(self) -> None:
        self._nodes: deque[Node] = deque(maxlen=round(WINDOW / NODE))
        self._fits: dict[Family, Fit] = {}
        self._peak: Peak | None = None
        self._fitted_at = -np.inf

    def update(self, sample: Checked, braked: bool) -> list[CurveEstimate]:
        """Take the next sample; return the estimate of each driven wheel, none while none spins or a brake acts."""
        if not self.driven:
            return []
        if braked or sample.after_gap or not np.isfinite(sample.wheel_speed).all() or not isfinite(sample.acceleration):
            self.reset()
            return []
        last, self._last = self._last, sample
        if last is None:
            return []
        interval = sample.time - last.time
        self._gathered += interval
        self._turned += interval * sample.wheel_speed
        self._pushed += interval * 0.5 * (sample.acceleration + last.acceleration)
        if self._gathered >= 0.99 * NODE:
            self._add(sample.time)
        return [] if self._peak is None else self._answer(self._peak)

    def _add(self, time: float) -> None:
        """Make a node of what was gathered, and fit the curve where wheels spin."""
        dt, before = self._gathered, self._speed
        rim, pushed = self._radii * self._turned / dt, self._pushed / dt / self._scale
        self._gathered, self._pushed, self._turned = 0.0, 0.0, np.zeros(len(self._radii))
        speed = self._speed = float(rim[self._free].mean())
        if speed < self._minimum_speed or isnan(before):
            self._forget()
            return
        way = dt * speed / self._length
        slip, kept = 1.0 - rim[self.driven] / speed, exp(-way)
        self._by_length = kept * (self._by_length - way * (slip - self._slip))
        relaxed = slip + kept * (self._slip - slip)
        rate, self._slip = (relaxed - self._slip) / dt, relaxed
        spun, self._rim = (rim[self.driven] - self._rim) / dt, rim[self.driven]
        self._pitch.step(dt, pushed)
        load = self._load + self._transfer * (self._pitch.moved + self._dampers * self._pitch.rate)
        resisted = self._spinning * (speed - before) / dt - float(coasting_acceleration(self._vehicle, speed))
        friction = (pushed + resisted) / load
        apart = self._inertia * (spun - spun.mean()) / load  # torque that turns one wheel faster than the other
        across = speed * 2.0 * float((self._right * rim[self._free]).mean()) / self._track / GRAVITY
        self._across += (across - self._across) * min(dt / ACROSS_TIME, 1.0)
        sideways = self._across / max(friction, LEAST_NOISE)
        if abs(sideways) > SIDEWAYS and abs(self._across) > LEAST_NOISE:
            return
        whole = hypot(1.0, min(abs(sideways), SIDEWAYS) / ACROSS)  # slip and friction of a tyre point the same way
        slips = whole * np.array([relaxed, self._by_length, rate])
        node = Node(slips, whole * (apart - friction), whole / load, whole)
        self._nodes.append(node)
        if float(relaxed.min()) < -SPINS and len(self._nodes) >= FEWEST and time - self._fitted_at >= INTERVAL:
            self._fitted_at = time
            self._peak = self._fit()
        elif time - self._fitted_at > LASTS:
            self._peak = None
        peak = self._peak
        if peak is not None and -node.friction.min() > exp(peak.log_mu + 3.0 * peak.log_mu_stddev):
            self._forget()  # a road that gives more than the peak of the last one is another

    def _fit(self) -> Peak:
        """Fit the families to the nodes, and take them together by their evidence."""
        slips = np.array([node.slips for node in self._nodes])
        friction = np.array([node.friction for node in self._nodes])
        by_bias = np.array([node.by_bias for node in self._nodes])
        for family, shape in self._families.items():
            before = self._fits.get(family)
            self._fits[family] = fit_curve(family, shape, slips, friction, by_bias, self._of_car, before)
        fits = list(self._fits.values())
        evidence = np.array([fit.log_evidence for fit in fits])
        weights = np.exp(evidence - evidence.max())
        weights /= weights.sum()
        means = np.array([fit.unknowns[: LAMBDA + 1] for fit in fits])
        variances = np.array([np.diagonal(fit.covariance)[: LAMBDA + 1] for fit in fits])
        mean = weights @ means
        log_mu_stddev, log_lambda_stddev = np.sqrt(weights @ (variances + (means - mean) ** 2)).tolist()
        best = fits[int(weights.argmax())]
        far = exp(float(mean[LAMBDA]) + SURE * min(log_lambda_stddev, 1.0))
        return Peak(
            float(mean[MU]),
            hypot(log_mu_stddev, self._scale_stddev, fmean(node.whole for node in self._nodes) - 1.0),
            best.misfit < ROUGH and abs(best.off) < OFF,
            len(self._nodes),
            (slips[:, 0] < -far).sum(axis=0) * NODE,
        )

    def _answer(self, peak: Peak) -> list[CurveEstimate]:
        mu_max = exp(peak.log_mu)
        smooth = peak.smooth and peak.log_mu_stddev < LARGEST
        answers = []
        for slip, beyond in zip(self._slip.tolist(), peak.beyond.tolist(), strict=True):
            reason, text = Reason.NO_EXCITATION, "mu_max from spinning wheels; lambda_max: waiting for a braking"
            if beyond < BEYOND:
                reason, text = Reason.PEAK_NOT_PASSED, "waiting for a wheel to pass the peak"
            elif not smooth:
                reason, text = Reason.UNCERTAIN, "the wheels follow no common curve: run vehicle_doctor"
            known = smooth and beyond >= BEYOND
            stddev = mu_max * peak.log_mu_stddev
            answers.append(
                CurveEstimate(
                    peak.nodes,
                    slip,
                    mu_max=mu_max if known else nan,
                    mu_max_stddev=stddev if known else nan,
                    reason=reason,
                    text=text,
                    mu_max_known=known,
                )
            )
        return answers
