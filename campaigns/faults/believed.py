"""Valid, consistent and wrong slips, speeds, curves and pressures as faults of the campaign."""

from typing import Any

from friction_msgs.msg import Validity

from benchmarks.protocol import DT
from campaigns.faults.case import Fault, Site, changed, keeping
from vehicle_models import burckhardt
from vehicle_models.surfaces import surface

_SLIP = 0.3
"""By which slips are too large, and speeds too high, as a share."""
_DRIFT = 0.1
"""Share of the speed by which it is too high after a second more."""
_PEAK, _PEAK_STDDEV = 0.04, 0.002
"""lambda_max of the curve that is believed, and the deviation that it claims [-]."""


def slip_too_large(site: Site, wheels: int | None = None) -> Fault:
    """Slip is too large, beside a speed that is right."""

    def change(message: Any) -> None:
        if message.validity.valid:
            message.slip = min(message.slip + _SLIP, 1.0)

    return changed(site.topics("slip", wheels), change)


def _faster(message: Any, share: float) -> None:
    if message.validity.valid:
        message.vehicle_speed *= 1.0 + share
        message.slip = 1.0 - (1.0 - message.slip) / (1.0 + share)


def speed_too_high(site: Site, wheels: int | None = None) -> Fault:
    """The speed jumps, and slip with it."""
    return changed(site.topics("slip", wheels), lambda message: _faster(message, _SLIP))


def speed_drifts(site: Site, wheels: int | None = None) -> Fault:
    """The speed is more and more too high, and slip with it."""
    topics, seen = site.topics("slip", wheels), [0]

    def change(message: Any) -> None:
        seen[0] += 1
        _faster(message, min(_DRIFT * DT * seen[0] / len(topics), _SLIP))

    return changed(topics, change)


def peak_too_early(site: Site, wheels: int | None = None) -> Fault:
    """The friction curve is that of dry asphalt with its peak at far too little slip, and certain of it."""
    theta_1, theta_2, theta_3 = surface("dry")
    lambda_max, mu_max = (float(value) for value in burckhardt.peak(surface("dry")))
    closer = lambda_max / _PEAK

    def change(message: Any) -> None:
        message.theta_1, message.theta_2, message.theta_3 = theta_1, closer * theta_2, closer * theta_3
        message.lambda_max, message.lambda_max_stddev, message.mu_max = _PEAK, _PEAK_STDDEV, mu_max
        message.validity, message.samples = Validity(valid=True), max(message.samples, 50)

    return changed(site.topics("friction_curve", wheels), change)


def pressure_stuck(site: Site) -> Fault:
    """The pressure of the first wheel keeps its value, under stamps that go on."""
    read = keeping()

    def change(message: Any) -> None:
        message.fluid_pressure = read(message.fluid_pressure)

    return changed(site.pressures[:1], change)
