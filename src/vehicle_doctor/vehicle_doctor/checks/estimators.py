"""Which estimators can run on these topics, and what the others lack."""

from vehicle_doctor.drive import IMU, SPEED, WHEEL_STATES, Drive, pressure_topic
from vehicle_doctor.finding import Finding, Verdict


def check(drive: Drive) -> list[Finding]:
    """Return a finding for each estimator."""
    there = set(drive.topics) | set(drive.others)
    wheels = drive.vehicle.wheel_names
    pressures = [pressure_topic(name) for name in wheels]
    motion = [WHEEL_STATES] if WHEEL_STATES not in there else []
    speed = [] if {IMU, SPEED} & there else [f"{IMU} or {SPEED}"]
    braked = [topic for topic in pressures if topic not in there]
    demand = [] if "brake_demand" in there else ["brake_demand"]
    tyres = [topic for name in wheels if (topic := f"{name}/tyre_signals") not in there]
    needs = {
        "wheel_slip": motion + speed,
        "friction_slope": motion + speed + braked,
        "friction_curve_id": motion + speed + braked,
        "abs_supervisor": motion + speed + braked + demand,
        "smart_tyre_forces": tyres,
    }
    return [
        Finding("estimator", name, Verdict.NOTE if lacks else Verdict.OK,
                f"lacks {', '.join(lacks)}" if lacks else "has its inputs")
        for name, lacks in needs.items()
    ]  # fmt: skip
