"""friction_adapter beside a bare relay of the same messages: processor time, side by side."""

from __future__ import annotations

import os
import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
from rich.progress import track
from sensor_msgs.msg import JointState

from benchmarks.rows import Row, at_most, not_judged
from campaigns.live.recorded_run import PLAYER, SOURCE, Drive, observe, record
from friction_bringup.discovery import local_discovery
from friction_bringup.processes import ProcessGroup
from friction_runtime.domain import free_domain_id
from friction_runtime.machine_load import slowdown

_DRIVE = Drive("compact_car", ("/car",), "two_axle", tyres=False)
_ROUNDS = 3
_MOST = 1.5
_ADAPTER, _RELAY = "friction_adapter", "bare relay"
_MAP = f"""vehicle: {_DRIVE.vehicle}
signals:
  wheel_speed:
    from: {{topic: /car/wheel_states, type: sensor_msgs/msg/JointState}}
    field: "velocity[name={{joint}}]"
    unit: rpm
  acceleration: {{from: {{topic: /car/imu/data, type: sensor_msgs/msg/Imu}}, field: linear_acceleration.x, unit: g}}
  brake_pressure:
    from: {{topic: "/car/{{wheel}}/brake_pressure", type: sensor_msgs/msg/FluidPressure}}
    field: fluid_pressure
    unit: bar
"""


def adapter_rows(seconds: float) -> list[Row]:
    """Play joint states, IMU and four pressures at 200 Hz for `seconds` [s] to both; a row a round, then the rule."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory(prefix="friction_recording_") as directory:
        bag, signal_map = Path(directory, "bag"), Path(directory, "map.yaml")
        signal_map.write_text(_MAP, encoding="utf-8")
        record(_DRIVE, seconds, bag)
        for number in track(range(_ROUNDS), "rounds"):
            rows.append({"run": f"round {number + 1}", **_round(bag, signal_map, Path(directory, f"log_{number}"))})
    ratios = [float(row[f"{_ADAPTER} [% of a core]"]) / float(row[f"{_RELAY} [% of a core]"]) for row in rows]
    lost = sum(int(row["lost"]) for row in rows)
    return [
        *rows,
        {"run": "all", "quantity": "processor time over that of the relay", **at_most(float(np.median(ratios)), _MOST)},
        {"run": "all", "quantity": "samples that one of the two lost", **not_judged(float(lost))},
    ]


def _round(bag: Path, signal_map: Path, logs: Path) -> Row:
    os.environ.update(local_discovery())
    env = os.environ | {"ROS_DOMAIN_ID": str(free_domain_id()), "OMP_NUM_THREADS": "1"}
    parameters = ("-p", f"vehicle_file:={_DRIVE.vehicle}", "-p", f"map_file:={signal_map}")
    adapter = ["friction_adapter", "--ros-args", "-r", "__ns:=/mapped", *parameters]
    relay = ["campaigns.live.bare_relay", _DRIVE.vehicle, "/car", "/relayed"]
    play = ["friction_bags", "play", str(bag), "--wait", "8", "--settle", str(2.0 * slowdown()), "--subscribers", "2"]
    processes = ProcessGroup(logs)
    try:
        for name, module in ((_ADAPTER, adapter), (_RELAY, relay)):
            processes.start(name, [sys.executable, "-m", *module], env)
        start = partial(processes.start, PLAYER, [sys.executable, "-m", *play], env)
        taps = {f"{place}/{SOURCE}": JointState for place in ("/car", "/mapped", "/relayed")}
        measured = observe(taps, env["ROS_DOMAIN_ID"], processes, start, lambda _: None)
    finally:
        processes.stop()
    sent, *made = (each.published.keys() for each in measured.answers.values())
    row: Row = {f"{name} [% of a core]": 100.0 * measured.processor[name] for name in (_ADAPTER, _RELAY)}
    return {**row, "samples": len(sent), "lost": sum(len(sent - each) for each in made)}
