"""CPU of the smart tyre: the algorithm alone, and the live node with the middleware around it."""

import os
import subprocess
import sys
import time
from array import array

import numpy as np
import rclpy
from friction_msgs.msg import TyreSignals
from rclpy.node import Node
from std_msgs.msg import Header

from benchmarks.smart_tyre.runs import TRACKER, WHEEL, WHEEL_SEEDS, simulate
from friction_bringup.discovery import local_discovery
from friction_runtime import qos
from friction_runtime.domain import free_domain_id
from friction_runtime.stamps import from_nanoseconds
from smart_tyre_forces.calibration import Calibration
from smart_tyre_forces.correction import PatchCorrection
from smart_tyre_forces.forces import forces
from smart_tyre_forces.patch_tracker import PatchTracker
from smart_tyre_forces.tooth_table import ToothTable
from vehicle_models.force_history import dynamic_drive
from vehicle_models.tyre_signal import TyreBlock
from vehicle_models.vehicle_file import load_vehicle

_VEHICLE = "smart_tyre_car"
_WHEELS = load_vehicle(_VEHICLE).wheel_names
_BLOCK = 100
"""Samples: 10 ms."""
_LIVE_SECONDS = 15.0
_CRUISE = 250_000
"""Sample of the drive from which it cruises: the most revolutions a second."""


def algorithm(known: Calibration) -> list[tuple[str, float]]:
    """CPU of four wheels in 10 ms blocks over the dynamic drive, in % of a core."""
    drive = dynamic_drive(road_seed=0)
    blocks = {axle: simulate(drive, axle, 0) for axle in WHEEL_SEEDS}
    spent, sampled = 0.0, 0.0
    for axle, block in blocks.items():
        wheel = known.wheels[axle]
        tracker = PatchTracker(WHEEL, TRACKER, ToothTable(np.asarray(wheel.tooth_table)))
        correction = PatchCorrection(known.tyre, WHEEL.radius, TRACKER.sample_rate)
        began = time.process_time()
        for first in range(0, len(block.encoder_voltage), _BLOCK):
            part = slice(first, first + _BLOCK)
            for passage in tracker.push(first, block.encoder_voltage[part], block.radial_acceleration[part]):
                forces(correction.update(passage), known.tyre, wheel, correction.zero_speed, restore_steady=True)
        spent += time.process_time() - began
        sampled += len(block.encoder_voltage) / TRACKER.sample_rate
    return [("four wheels, 10 ms blocks, algorithm [% of a core]", 100.0 * len(_WHEELS) * spent / sampled)]


def live_node() -> list[tuple[str, float]]:
    """CPU of the live node with four wheels over DDS, in % of a core."""
    block = simulate(dynamic_drive(road_seed=0), "front", 0)
    os.environ |= {"ROS_DOMAIN_ID": str(free_domain_id()), **local_discovery()}
    command = [sys.executable, "-m", "smart_tyre_forces", "--ros-args", "-p", f"vehicle_file:={_VEHICLE}"]
    process = subprocess.Popen(command)
    rclpy.init()
    node = rclpy.create_node("tyre_cost")
    try:
        return [("four wheels, 10 ms blocks, live node over DDS [% of a core]", _feed(node, process.pid, block))]
    finally:
        process.terminate()
        process.wait(timeout=10.0)
        node.destroy_node()
        rclpy.try_shutdown()


def _feed(node: Node, pid: int, block: TyreBlock) -> float:
    """Publish the cruise of the drive in real time; return the share of a core the process took [%]."""
    publishers = [qos.publish(node, TyreSignals, f"{wheel}/tyre_signals") for wheel in _WHEELS]
    patience = time.monotonic() + 20.0
    while not all(p.get_subscription_count() for p in publishers):
        if time.monotonic() > patience:
            raise TimeoutError("smart_tyre_forces does not subscribe to its blocks")
        time.sleep(0.05)
    began, spent = time.monotonic(), _cpu_seconds(pid)
    for k in range(round(_LIVE_SECONDS * TRACKER.sample_rate) // _BLOCK):
        part = slice(_CRUISE + k * _BLOCK, _CRUISE + (k + 1) * _BLOCK)
        due = k * _BLOCK / TRACKER.sample_rate
        for wheel, publisher in zip(_WHEELS, publishers, strict=True):
            message = TyreSignals(
                header=Header(stamp=from_nanoseconds(1_000_000_000 + round(due * 1e9)), frame_id=wheel),
                wheel=wheel,
                sample_rate=TRACKER.sample_rate,
                first_sample=k * _BLOCK,
                encoder_voltage=array("f", block.encoder_voltage[part].tobytes()),
                radial_acceleration=array("f", block.radial_acceleration[part].tobytes()),
                inflation_pressure=np.nan,
            )
            publisher.publish(message)
        time.sleep(max(0.0, began + due - time.monotonic()))
    return 100.0 * (_cpu_seconds(pid) - spent) / (time.monotonic() - began)


def _cpu_seconds(pid: int) -> float:
    """User and system time of a process so far [s]."""
    with open(f"/proc/{pid}/stat", encoding="ascii") as stat:
        counters = stat.read().rsplit(")", 1)[1].split()
    return (int(counters[11]) + int(counters[12])) / os.sysconf("SC_CLK_TCK")
