"""Catalogue of the faults, and the plans of the whole and of the quick campaign."""

from collections.abc import Sequence
from functools import partial

from benchmarks.protocol import DT
from campaigns.faults import believed, sensors, transport
from campaigns.faults.case import (
    BEFORE_BRAKING,
    CORNER,
    FOUR_WHEELS,
    FROM_START,
    Case,
    Hit,
    Manoeuvre,
    Site,
    at_once,
    constant,
    frozen,
    lagging,
    scaled,
    silent,
)
from friction_runtime.wheel_inputs import WHEEL_STATES
from vehicle_models.surfaces import TABLE_8_1

_DEMAND = "brake_demand"
_NAN = float("nan")
FAIL_SAFE = 0.05 + DT
"""[s] The fail-safe's 50 ms and the period of the inputs."""
_CONTRADICTION = 0.1
"""[s] From a contradiction between wheels to NONE."""
_RELEASE = 0.3
"""[s] The longest release: a wheel that was about to lock is seen to be dead when it does not make it turn."""
_MISMATCH = 0.5
"""[s] of braking, after which a pressure that does not follow the demand is named."""
_LATE_STRETCH = 1.02
_WRONG = 0.2
"""[s] for which a valid slip may be wrong."""
_SHARE = 0.05
"""Of the messages that are dropped, duplicated or reordered."""
_LATE = {"share": 0.01, "delay": 0.007}

FIRST, ALL = Hit.FIRST_WHEEL, Hit.ALL_WHEELS
NO_FAULT = Case("none", lambda site: at_once, begin=BEFORE_BRAKING, wrong_for=_WRONG)


def _sensors(site: Site) -> tuple[str, ...]:
    return (WHEEL_STATES, "imu/data", "vehicle_velocity", _DEMAND, *site.pressures)


NOISE = (
    Case("wheel_noise_x3", sensors.noisy, ALL, BEFORE_BRAKING, wrong_for=_WRONG),
    Case("wheel_ripple", sensors.rippled, ALL, BEFORE_BRAKING),
    Case("wheel_ripple_always", sensors.rippled, ALL, FROM_START, wrong_for=_WRONG),
)
WHEEL_SENSOR = (
    Case(
        "wheel_dead",
        sensors.dead,
        FIRST,
        none_within=_CONTRADICTION,
        none_later=_RELEASE,
        named_within=_CONTRADICTION,
        named="front_left",
        wrong_for=_WRONG,
    ),
    Case(
        "wheel_dead_before",
        sensors.dead,
        FIRST,
        BEFORE_BRAKING,
        named_within=_CONTRADICTION,
        named="front_left",
        wrong_for=_WRONG,
    ),
    Case("wheel_stuck", sensors.stuck, FIRST, wrong_for=_WRONG),
    Case(
        "wheel_flicker",
        sensors.flickering,
        FIRST,
        BEFORE_BRAKING,
        named_within=_CONTRADICTION,
        named="front_left",
        wrong_for=_WRONG,
    ),
    Case("wheel_+5%", partial(sensors.biased, factor=1.05), FIRST, BEFORE_BRAKING, wrong_for=_WRONG),
    Case("wheel_-5%", partial(sensors.biased, factor=0.95), FIRST, BEFORE_BRAKING, wrong_for=_WRONG),
    Case("wheel_nan", sensors.not_a_number, FIRST, none_within=FAIL_SAFE),
    Case("wheel_missing", sensors.missing, FIRST, none_within=FAIL_SAFE),
    Case("wheel_states_silent", lambda site: silent([WHEEL_STATES]), ALL, none_within=FAIL_SAFE),
    Case("wheel_states_frozen", lambda site: frozen([WHEEL_STATES]), ALL, none_within=FAIL_SAFE),
)
_FIELD = "fluid_pressure"
PRESSURE = (
    Case(
        "pressure_zero",
        lambda site: constant(site.pressures[:1], _FIELD, 0.0),
        FIRST,
        BEFORE_BRAKING,
        named_within=_MISMATCH,
        named="brake_pressure",
        wrong_for=_WRONG,
    ),
    Case(
        "pressure_half",
        lambda site: scaled(site.pressures[:1], _FIELD, 0.5),
        FIRST,
        BEFORE_BRAKING,
        named_within=_MISMATCH,
        named="brake_pressure",
        wrong_for=_WRONG,
    ),
    Case(
        "pressure_60ms",
        lambda site: lagging(site.pressures[:1], _FIELD, round(0.06 / DT)),
        FIRST,
        BEFORE_BRAKING,
        named_within=_MISMATCH,
        named="brake_pressure",
        wrong_for=_WRONG,
    ),
    Case("pressure_nan", lambda site: constant(site.pressures[:1], _FIELD, _NAN), FIRST, none_within=FAIL_SAFE),
    Case("pressure_silent", lambda site: silent(site.pressures[:1]), FIRST, none_within=FAIL_SAFE),
    Case("pressure_frozen", lambda site: frozen(site.pressures[:1]), FIRST, none_within=FAIL_SAFE, wrong_for=_WRONG),
)
DEMAND = (
    Case("demand_silent", lambda site: silent([_DEMAND]), ALL, none_within=FAIL_SAFE),
    Case("demand_nan", lambda site: constant([_DEMAND], "pressure", _NAN), ALL, none_within=FAIL_SAFE),
    Case("demand_frozen", lambda site: frozen([_DEMAND]), ALL, none_within=FAIL_SAFE),
)
GRAPH = (
    Case("slip_lost", partial(transport.lost, name="slip")),
    Case("curve_lost", partial(transport.lost, name="friction_curve")),
    Case("slope_lost", partial(transport.lost, name="slope_vote"), ALL, none_within=FAIL_SAFE),
    Case("slope_invalid", transport.invalid_slope, FIRST, none_within=FAIL_SAFE),
    Case("command_lost", partial(transport.lost, name="brake_command"), ALL),
)
BELIEVED = (
    Case("slip_+0.3", partial(believed.slip_too_large, wheels=1), FIRST),
    Case("all_slips_+0.3", believed.slip_too_large, ALL),
    Case("speed_+30%", partial(believed.speed_too_high, wheels=1), FIRST),
    Case("all_speeds_+30%", believed.speed_too_high, ALL),
    Case("all_speeds_drift", believed.speed_drifts, ALL),
    Case("curve_0.04", partial(believed.peak_too_early, wheels=1), FIRST),
    Case("all_curves_0.04", believed.peak_too_early, ALL),
    Case("all_curves_0.04_before", believed.peak_too_early, ALL, BEFORE_BRAKING),
    Case("pressure_stuck", believed.pressure_stuck, FIRST),
    Case("all_slips_+0.3_before", believed.slip_too_large, ALL, BEFORE_BRAKING),
)
"""Valid, consistent and wrong: what law and slip monitor have to believe."""
IMU = (
    Case("imu_dead", sensors.imu_dead, wrong_for=_WRONG),
    Case("imu_dead_before", sensors.imu_dead, begin=BEFORE_BRAKING, wrong_for=_WRONG),
    Case("imu_biased", sensors.imu_biased, begin=BEFORE_BRAKING, wrong_for=_WRONG),
    Case("imu_stuck", sensors.imu_stuck, wrong_for=_WRONG),
)
STAMPS = (
    Case("stamps_repeat", lambda site: transport.repeating([WHEEL_STATES]), ALL, none_within=FAIL_SAFE),
    Case("stamps_zero", lambda site: transport.zero([WHEEL_STATES]), ALL, none_within=FAIL_SAFE),
    Case("stamps_crawl", lambda site: transport.crawling([WHEEL_STATES]), ALL, none_within=FAIL_SAFE),
    Case("stamps_back_50ms", lambda site: transport.shifted([WHEEL_STATES], -0.05), ALL, none_within=FAIL_SAFE),
    Case("all_stamps_repeat", lambda site: transport.repeating(_sensors(site)), ALL, none_within=FAIL_SAFE),
    Case("all_stamps_crawl", lambda site: transport.crawling(_sensors(site)), ALL, none_within=FAIL_SAFE),
    Case("all_stamps_back_50ms", lambda site: transport.shifted(_sensors(site), -0.05), ALL, none_within=FAIL_SAFE),
    Case("pressure_stamps_repeat", lambda site: transport.repeating(site.pressures[:1]), FIRST, none_within=FAIL_SAFE),
    Case("demand_stamps_crawl", lambda site: transport.crawling([_DEMAND]), ALL, none_within=FAIL_SAFE),
    Case("clock_+1s", lambda site: transport.clock_jump(site, _sensors(site), 1.0), ALL),
    Case("clock_-1s", lambda site: transport.clock_jump(site, _sensors(site), -1.0), ALL),
    Case("clock_+1h", lambda site: transport.clock_jump(site, _sensors(site), 3600.0), ALL),
    Case("clock_-1h", lambda site: transport.clock_jump(site, _sensors(site), -3600.0), ALL),
)
TRANSPORT = (
    Case(
        "late_7ms",
        lambda site: transport.late(site, _sensors(site), **_LATE),
        begin=BEFORE_BRAKING,
        stretch=_LATE_STRETCH,
    ),
    Case("dropped", lambda site: transport.dropped(site, _sensors(site), _SHARE), begin=BEFORE_BRAKING),
    Case("duplicated", lambda site: transport.duplicated(site, _sensors(site), _SHARE), begin=BEFORE_BRAKING),
    Case("reordered", lambda site: transport.reordered(site, _sensors(site), _SHARE), begin=BEFORE_BRAKING),
    Case("wheel_states_twice", transport.replayed_beside, ALL),
    Case("demand_twice", transport.second_demand, ALL),
)
FAULTS = (*NOISE, *WHEEL_SENSOR, *PRESSURE, *DEMAND, *GRAPH, *BELIEVED, *IMU, *STAMPS, *TRANSPORT)
"""All of them."""
LOCKED_START = Case("locked_start", partial(transport.lost, name="brake_command"), ALL, BEFORE_BRAKING, end=1.5)
"""Commands reach the brake only when the wheel has locked."""
CASES = {case.name: case for case in (NO_FAULT, *FAULTS, LOCKED_START)}
"""By name."""


Plan = Sequence[tuple[Manoeuvre, Sequence[Case]]]

_FAULT_DEMANDS = (0.6, 1.5)
_ORDINARY = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)


def whole() -> Plan:
    """Return every car and surface: all faults at 0.6 and 1.5, ordinary and noisy braking at 0.1 to 0.9."""
    found: list[tuple[Manoeuvre, Sequence[Case]]] = []
    for car in (CORNER, FOUR_WHEELS):
        for surface in TABLE_8_1:
            for demand in sorted({*_ORDINARY, *_FAULT_DEMANDS}):
                cases = (NO_FAULT, *FAULTS) if demand in _FAULT_DEMANDS else (NO_FAULT, *NOISE)
                found.append((Manoeuvre(car, surface, demand), cases))
        found.append((Manoeuvre(car, "snow", 1.5), (LOCKED_START,)))
    return found


def quick() -> Plan:
    """Return the subset: the corner with every fault, the car with the faults that differ where wheels are compared."""
    return [
        (Manoeuvre(CORNER, "dry", 0.2), (NO_FAULT,)),
        (Manoeuvre(CORNER, "cobblestone", 0.8), (NO_FAULT, *NOISE)),
        (Manoeuvre(CORNER, "wet", 1.5), (NO_FAULT, *STAMPS, *TRANSPORT)),
        (Manoeuvre(CORNER, "dry", 0.6), (NO_FAULT, *FAULTS)),
        (Manoeuvre(FOUR_WHEELS, "dry", 0.6), (NO_FAULT, *NOISE)),
        (Manoeuvre(FOUR_WHEELS, "dry", 1.5), (NO_FAULT, *WHEEL_SENSOR, *PRESSURE, *GRAPH, *IMU)),
        (Manoeuvre(FOUR_WHEELS, "cobblestone", 0.6), BELIEVED),
    ]
