"""Checks of the recording itself: rates and stamps of the topics, quantization, and the inputs of each estimator."""

from dataclasses import replace

import numpy as np

from vehicle_doctor.drive import IMU, SPEED, WHEEL_STATES, Array, Drive, Recorded, kinds, pressure_topic
from vehicle_doctor.findings import Finding, Verdict

_SLOW_WHEELS = 20.0
"""Rate [Hz] below which a wheel's slip through a stop is not seen."""
_GAP = 0.1
"""Shortest gap [s]."""
_SHIFTED = 2.0
"""Time by which a topic begins later and ends later than another one only where their clocks differ [s]."""
_JITTER = 0.4
"""Deviation of a step over the step from which stamps are those of an arrival and not of a measurement."""


def check_topics(drive: Drive) -> list[Finding]:
    """Check rate, gaps, jitter and stamps of each topic."""
    found = []
    for topic in kinds(drive.vehicle):
        recorded = drive.topics.get(topic)
        if recorded is not None:
            found.append(_topic(topic, recorded))
        elif topic in (WHEEL_STATES, IMU):
            found.append(
                Finding(
                    "topic",
                    topic,
                    Verdict.FAIL if topic == WHEEL_STATES else Verdict.WARN,
                    "has no message",
                    remedy="record it, or name where it comes from in a signal map",
                )
            )
    known, strange = ", ".join(drive.vehicle.joints), ", ".join(drive.strange_joints)
    if not _has_wheels(drive) and WHEEL_STATES in drive.topics:
        text = f"holds none of the wheels of the car ({known}), but {strange or 'no values'}"
        remedy = "name the joints in the vehicle file, or the wheels in a signal map"
        found.append(Finding("topic", WHEEL_STATES, Verdict.FAIL, text, remedy=remedy))
    elif strange:
        text = f"also holds {strange}, which are no wheels of the car ({known})"
        found.append(Finding("topic", WHEEL_STATES, Verdict.NOTE, text))
    if drive.wheels_in_parts:
        parts = "; ".join(", ".join(names) for names in drive.wheels_in_parts)
        text = f"comes in parts, of one sender each ({parts}): estimators need all wheels of a sample in one message"
        remedy = "give each sender a topic of its own, and merge them by a signal map with friction_adapter"
        found.append(Finding("topic", WHEEL_STATES, Verdict.FAIL, text, remedy=remedy))
    for topic, ahead in _other_clocks(drive).items():
        text = f"stamps are {ahead:+.1f} s from those of {WHEEL_STATES}: they are of two clocks"
        remedy = "stamp both by one clock, or give 'latency' in the signal map"
        found.append(Finding("clock", topic, Verdict.FAIL, text, ahead, unit="s", remedy=remedy))
    if drive.unstamped:
        text = f"{drive.unstamped} messages have no stamp"
        found.append(Finding("stamps", "all", Verdict.FAIL, text, remedy="stamp each message when it is measured"))
    return found


def _has_wheels(drive: Drive) -> bool:
    """Whether some wheel of the car has a speed somewhere."""
    recorded = drive.topics.get(WHEEL_STATES)
    return recorded is not None and bool(np.isfinite(recorded.values).any())


def _other_clocks(drive: Drive) -> dict[str, float]:
    """Return topics that begin and end as far from the wheels as no recorder makes them, and by how much [s]."""
    wheels = drive.topics.get(WHEEL_STATES)
    if wheels is None or not wheels.stamp.size:
        return {}
    found = {}
    for topic in kinds(drive.vehicle):
        recorded = drive.topics.get(topic)
        if topic == WHEEL_STATES or recorded is None or not recorded.stamp.size:
            continue
        begins = float(recorded.stamp.min() - wheels.stamp.min())
        ends = float(recorded.stamp.max() - wheels.stamp.max())
        apart = recorded.stamp.min() > wheels.stamp.max() or recorded.stamp.max() < wheels.stamp.min()
        if apart or (min(abs(begins), abs(ends)) > _SHIFTED and abs(begins - ends) < 0.5 * _SHIFTED):
            found[topic] = begins
    return found


def _topic(topic: str, recorded: Recorded) -> Finding:
    steps = np.diff(recorded.stamp)
    forward = steps[steps > 0.0]
    if forward.size < 5:
        return Finding("topic", topic, Verdict.WARN, f"{recorded.stamp.size} messages: too few to examine")
    period = float(np.median(forward))
    back, same = int((steps < 0.0).sum()), int((steps == 0.0).sum())
    gaps = forward[forward > max(_GAP, 4.0 * period)]
    jitter = float(np.median(np.abs(forward - period)) * 1.48)
    unknown = int((~np.isfinite(recorded.values[:, 0])).sum()) if topic == WHEEL_STATES else 0
    text = f"{recorded.stamp.size} messages, {1.0 / period:.1f} Hz, jitter {1e3 * jitter:.1f} ms"
    problems, remedies = [], []
    if back:
        problems.append(f"{back} stamps go back in time")
        remedies.append("find the second sender, or stamp by the time of measurement")
    if same > 0.01 * steps.size:
        problems.append(f"{same} messages repeat a stamp")
        remedies.append("stamp each message with its own time")
    if gaps.size:
        problems.append(f"{gaps.size} gaps, the longest {gaps.max():.2f} s")
        remedies.append("look for lost messages between sensor and recorder")
    if jitter > _JITTER * period:
        problems.append("stamps are uneven")
        remedies.append("stamp by the time of measurement, not of arrival")
    if topic == WHEEL_STATES and 1.0 / period < _SLOW_WHEELS:
        problems.append(f"below {_SLOW_WHEELS:.0f} Hz a slip through the peak is not seen")
        remedies.append("record the wheels faster")
    if unknown:
        text += f", {unknown} without the first wheel"
    verdict = Verdict.FAIL if back else Verdict.WARN if problems else Verdict.OK
    return Finding(
        "topic", topic, verdict, "; ".join([text, *problems]), 1.0 / period, unit="Hz", remedy="; ".join(remedies)
    )


_CODE_SHARE, _CODE_REPEATS, _CODE_LEVELS = 0.2, 3, 20
"""Largest share and least number of samples that are a code for an error, and least number of other values."""
_CODE_APART = 0.6
"""Share of a code that no other value exceeds."""


def leave_out_codes(drive: Drive) -> tuple[list[Finding], Drive]:
    """Return findings on values that stand for an error, such as 0xFFFF, and the drive without them.

    They are the largest or the least of a signal, often the same, and far from every other one.
    """
    found, topics = [], dict(drive.topics)
    for topic, recorded in drive.topics.items():
        values = recorded.values.copy()
        for column in values.T:
            for code in _codes(column):
                count = int((column == code).sum())
                column[column == code] = np.nan
                text = f"has the value {code:.6g} in {count} messages, far from all others: a code for an error"
                remedy = f"'invalid: {code:.6g}' in the signal map, in its unit; left out here"
                found.append(Finding("signal", topic, Verdict.WARN, text, code, remedy=remedy))
        topics[topic] = replace(recorded, values=values)
    return found, replace(drive, topics=topics)


def _codes(column: Array) -> list[float]:
    codes = []
    for sign in (1.0, -1.0):
        known = sign * column[np.isfinite(column)]
        levels, counts = np.unique(known, return_counts=True)
        if levels.size <= _CODE_LEVELS or levels[-1] <= 0.0 or levels[-2] > _CODE_APART * levels[-1]:
            continue
        if _CODE_REPEATS <= counts[-1] <= _CODE_SHARE * known.size:
            codes.append(sign * float(levels[-1]))
    return codes


_DISTINCT = 0.25
"""Ratio of distinct values to samples above which a signal is not quantized."""
_MIN_SAMPLES = 200


def check_quantization(drive: Drive) -> list[Finding]:
    """Check the quantization step of each signal."""
    axis = "xyz".index(drive.vehicle.accelerometer.axis)
    columns = {WHEEL_STATES: 0, IMU: axis, SPEED: 0, **dict.fromkeys(map(pressure_topic, drive.vehicle.wheel_names), 0)}
    found = []
    for topic, column in columns.items():
        recorded = drive.topics.get(topic)
        step = np.nan if recorded is None else step_of(recorded.values[:, column])
        if recorded is None or not np.isfinite(step):
            continue
        known = recorded.values[np.isfinite(recorded.values[:, column]), column]
        low, high = np.percentile(known, [2, 98])
        share = step / max(float(high - low), 1e-12)
        # a step of a hundredth of what the signal spans is 1 % of a hard braking
        coarse = share > 0.01
        text = f"is counted in steps of {step:.3g}, 1/{1.0 / share:.0f} of what it spans"
        where = "as wheel_filter.speed_stddev of wheel_slip" if topic == WHEEL_STATES else "in the signal map"
        remedy = f"log it with more bits, or state the deviation {where}" if coarse else ""
        verdict = Verdict.WARN if coarse else Verdict.OK
        found.append(Finding("resolution", topic, verdict, text, step, remedy=remedy))
    return found


def step_of(values: Array) -> float:
    """Return the step of which all values are multiples, apart from a constant; NaN where there is none."""
    known = values[np.isfinite(values)]
    levels = np.unique(known)
    if known.size < _MIN_SAMPLES or levels.size < 3 or levels.size > _DISTINCT * known.size:
        return np.nan
    gaps = np.diff(levels)
    step = float(np.median(gaps[gaps > 1e-6 * np.ptp(levels)]))
    share = gaps / step
    return step if (np.abs(share - np.round(share)) < 0.05).mean() > 0.95 else np.nan


def check_estimator_inputs(drive: Drive) -> list[Finding]:
    """Check which estimators have all their inputs."""
    there = (set(drive.topics) | set(drive.others)) - set(_other_clocks(drive))
    if not _has_wheels(drive) or drive.wheels_in_parts:
        there.discard(WHEEL_STATES)
    wheels = drive.vehicle.wheel_names
    pressures = [pressure_topic(name) for name in wheels]
    motion = [WHEEL_STATES] if WHEEL_STATES not in there else []
    speed = [] if {IMU, SPEED} & there else [f"{IMU} or {SPEED}"]
    braked = [topic for topic in pressures if topic not in there]
    demand = [] if "brake_demand" in there else ["brake_demand"]
    tyres = [topic for name in wheels if (topic := f"{name}/tyre_signals") not in there]
    has_no_pressure = len(braked) == len(wheels)
    of_car = [] if IMU in there else [IMU]  # without any pressure, method `vehicle` fits one curve for the car
    needs = {
        "wheel_slip": motion + speed,
        "friction_slope": motion + speed + braked,
        "friction_curve_id": motion + (of_car if has_no_pressure else speed + braked),
        "abs_supervisor": motion + speed + braked + demand,
        "smart_tyre_forces": tyres,
        "friction_grip": motion + ([] if IMU in there else [IMU]),
        "friction_state": motion,
    }
    notes = {"friction_curve_id": " of method 'vehicle': one curve for the car"} if has_no_pressure else {}
    return [
        Finding("estimator", name, Verdict.NOTE if lacks else Verdict.OK,
                f"lacks {', '.join(lacks)}" if lacks else f"has its inputs{notes.get(name, '')}")
        for name, lacks in needs.items()
    ]  # fmt: skip
