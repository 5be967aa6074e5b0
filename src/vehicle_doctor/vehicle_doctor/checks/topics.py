"""What is there: rates, gaps, jitter and stamps of each topic."""

import numpy as np

from vehicle_doctor.drive import IMU, WHEEL_STATES, Drive, Recorded, kinds
from vehicle_doctor.finding import Finding, Verdict

_SLOW_WHEELS = 20.0
"""Rate [Hz] below which a wheel's slip through a stop is not seen."""
_GAP = 0.1
"""Shortest gap [s]."""
_JITTER = 0.4
"""Deviation of a step over the step from which stamps are those of an arrival and not of a measurement."""


def check(drive: Drive) -> list[Finding]:
    """Look at each topic."""
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
    if drive.strange_joints:
        known = ", ".join(drive.vehicle.joints)
        text = f"also holds {', '.join(drive.strange_joints)}, which are no wheels of the car ({known})"
        found.append(Finding("topic", WHEEL_STATES, Verdict.NOTE, text))
    if drive.unstamped:
        text = f"{drive.unstamped} messages have no stamp"
        found.append(Finding("stamps", "all", Verdict.FAIL, text, remedy="stamp each message when it is measured"))
    return found


def _topic(topic: str, recorded: Recorded) -> Finding:
    steps = np.diff(recorded.stamp)
    forward = steps[steps > 0.0]
    if forward.size < 5:
        return Finding("topic", topic, Verdict.WARN, f"{recorded.stamp.size} messages: nothing can be said of it")
    period = float(np.median(forward))
    back, same = int((steps < 0.0).sum()), int((steps == 0.0).sum())
    gaps = forward[forward > max(_GAP, 4.0 * period)]
    jitter = float(np.median(np.abs(forward - period)) * 1.48)
    unknown = int((~np.isfinite(recorded.values[:, 0])).sum()) if topic == WHEEL_STATES else 0
    text = f"{recorded.stamp.size} messages, {1.0 / period:.1f} Hz, jitter {1e3 * jitter:.1f} ms"
    troubles, remedies = [], []
    if back:
        troubles.append(f"{back} stamps go back in time")
        remedies.append("find the second sender, or stamp by the time of measurement")
    if same > 0.01 * steps.size:
        troubles.append(f"{same} messages repeat a stamp")
        remedies.append("stamp each message with its own time")
    if gaps.size:
        troubles.append(f"{gaps.size} gaps, the longest {gaps.max():.2f} s")
        remedies.append("look for lost messages between sensor and recorder")
    if jitter > _JITTER * period:
        troubles.append("stamps are uneven")
        remedies.append("stamp by the time of measurement, not of arrival")
    if topic == WHEEL_STATES and 1.0 / period < _SLOW_WHEELS:
        troubles.append(f"below {_SLOW_WHEELS:.0f} Hz a slip through the peak is not seen")
        remedies.append("record the wheels faster")
    if unknown:
        text += f", {unknown} without the first wheel"
    verdict = Verdict.FAIL if back else Verdict.WARN if troubles else Verdict.OK
    return Finding(
        "topic", topic, verdict, "; ".join([text, *troubles]), 1.0 / period, unit="Hz", remedy="; ".join(remedies)
    )
