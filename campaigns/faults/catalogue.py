"""Every fault of the campaign."""

from functools import partial

from benchmarks.protocol import DT
from campaigns.faults import estimates, imu, stamps, transport, wheel_sensor
from campaigns.faults.case import BEFORE_BRAKING, Case, Hit
from campaigns.faults.fault import Site, at_once
from campaigns.faults.signals import constant, frozen, lagging, scaled, silent
from friction_runtime.wheel_speeds import WHEEL_STATES

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
_SHARE = 0.05
"""Of the messages that are dropped, duplicated or reordered."""
_LATE = {"share": 0.01, "delay": 0.007}

FIRST, ALL = Hit.FIRST_WHEEL, Hit.ALL_WHEELS
NO_FAULT = Case("none", lambda site: at_once, begin=BEFORE_BRAKING)


def _sensors(site: Site) -> tuple[str, ...]:
    return (WHEEL_STATES, "imu/data", "vehicle_velocity", _DEMAND, *site.pressures)


NOISE = (
    Case("wheel_noise_x3", wheel_sensor.noisy, ALL, BEFORE_BRAKING),
    Case("wheel_ripple", wheel_sensor.rippled, ALL, BEFORE_BRAKING),
)
WHEEL_SENSOR = (
    Case(
        "wheel_dead",
        wheel_sensor.dead,
        FIRST,
        none_within=_CONTRADICTION,
        none_later=_RELEASE,
        named_within=_CONTRADICTION,
        named="front_left",
    ),
    Case(
        "wheel_dead_before", wheel_sensor.dead, FIRST, BEFORE_BRAKING, named_within=_CONTRADICTION, named="front_left"
    ),
    Case("wheel_stuck", wheel_sensor.stuck, FIRST),
    Case(
        "wheel_flicker", wheel_sensor.flickering, FIRST, BEFORE_BRAKING, named_within=_CONTRADICTION, named="front_left"
    ),
    Case("wheel_+5%", partial(wheel_sensor.biased, factor=1.05), FIRST, BEFORE_BRAKING),
    Case("wheel_-5%", partial(wheel_sensor.biased, factor=0.95), FIRST, BEFORE_BRAKING),
    Case("wheel_nan", wheel_sensor.not_a_number, FIRST, none_within=FAIL_SAFE),
    Case("wheel_missing", wheel_sensor.missing, FIRST, none_within=FAIL_SAFE),
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
    ),
    Case(
        "pressure_half",
        lambda site: scaled(site.pressures[:1], _FIELD, 0.5),
        FIRST,
        BEFORE_BRAKING,
        named_within=_MISMATCH,
        named="brake_pressure",
    ),
    Case(
        "pressure_60ms",
        lambda site: lagging(site.pressures[:1], _FIELD, round(0.06 / DT)),
        FIRST,
        BEFORE_BRAKING,
        named_within=_MISMATCH,
        named="brake_pressure",
    ),
    Case("pressure_nan", lambda site: constant(site.pressures[:1], _FIELD, _NAN), FIRST, none_within=FAIL_SAFE),
    Case("pressure_silent", lambda site: silent(site.pressures[:1]), FIRST, none_within=FAIL_SAFE),
    Case("pressure_frozen", lambda site: frozen(site.pressures[:1]), FIRST, none_within=FAIL_SAFE),
)
DEMAND = (
    Case("demand_silent", lambda site: silent([_DEMAND]), ALL, none_within=FAIL_SAFE),
    Case("demand_nan", lambda site: constant([_DEMAND], "pressure", _NAN), ALL, none_within=FAIL_SAFE),
    Case("demand_frozen", lambda site: frozen([_DEMAND]), ALL, none_within=FAIL_SAFE),
)
GRAPH = (
    Case("slip_lost", partial(estimates.lost, name="slip")),
    Case("curve_lost", partial(estimates.lost, name="friction_curve")),
    Case("slope_lost", partial(estimates.lost, name="slope_vote"), ALL, none_within=FAIL_SAFE),
    Case("slope_invalid", estimates.invalid_slope, FIRST, none_within=FAIL_SAFE),
    Case("command_lost", partial(estimates.lost, name="brake_command"), ALL),
)
IMU = (
    Case("imu_dead", imu.dead),
    Case("imu_dead_before", imu.dead, begin=BEFORE_BRAKING),
    Case("imu_biased", imu.biased, begin=BEFORE_BRAKING),
    Case("imu_stuck", imu.stuck),
)
STAMPS = (
    Case("stamps_repeat", lambda site: stamps.repeating([WHEEL_STATES]), ALL, none_within=FAIL_SAFE),
    Case("stamps_zero", lambda site: stamps.zero([WHEEL_STATES]), ALL, none_within=FAIL_SAFE),
    Case("stamps_crawl", lambda site: stamps.crawling([WHEEL_STATES]), ALL, none_within=FAIL_SAFE),
    Case("stamps_back_50ms", lambda site: stamps.shifted([WHEEL_STATES], -0.05), ALL, none_within=FAIL_SAFE),
    Case("all_stamps_repeat", lambda site: stamps.repeating(_sensors(site)), ALL, none_within=FAIL_SAFE),
    Case("all_stamps_crawl", lambda site: stamps.crawling(_sensors(site)), ALL, none_within=FAIL_SAFE),
    Case("all_stamps_back_50ms", lambda site: stamps.shifted(_sensors(site), -0.05), ALL, none_within=FAIL_SAFE),
    Case("pressure_stamps_repeat", lambda site: stamps.repeating(site.pressures[:1]), FIRST, none_within=FAIL_SAFE),
    Case("demand_stamps_crawl", lambda site: stamps.crawling([_DEMAND]), ALL, none_within=FAIL_SAFE),
    Case("clock_+1s", lambda site: stamps.clock_jump(site, _sensors(site), 1.0), ALL),
    Case("clock_-1s", lambda site: stamps.clock_jump(site, _sensors(site), -1.0), ALL),
    Case("clock_+1h", lambda site: stamps.clock_jump(site, _sensors(site), 3600.0), ALL),
    Case("clock_-1h", lambda site: stamps.clock_jump(site, _sensors(site), -3600.0), ALL),
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
FAULTS = (*NOISE, *WHEEL_SENSOR, *PRESSURE, *DEMAND, *GRAPH, *IMU, *STAMPS, *TRANSPORT)
"""All of them."""
LOCKED_START = Case("locked_start", partial(estimates.lost, name="brake_command"), ALL, BEFORE_BRAKING, end=1.5)
"""Commands reach the brake only when the wheel has locked."""
CASES = {case.name: case for case in (NO_FAULT, *FAULTS, LOCKED_START)}
"""By name."""
