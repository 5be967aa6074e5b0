"""The calibration tool on bags of a simulated car."""

from array import array
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ament_index_python.packages import get_package_share_directory
from friction_msgs.msg import TyreSignals
from geometry_msgs.msg import Vector3
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from sensor_msgs.msg import Imu
from std_msgs.msg import Header

from friction_runtime.stamps import from_nanoseconds
from smart_tyre_forces.calibration import Calibration
from smart_tyre_forces.calibration_tool import main
from smart_tyre_forces.parameters import SmartTyreParameters
from smart_tyre_forces.processor import build
from vehicle_models.force_history import Drive, dynamic_drive, quasi_static_drives
from vehicle_models.tyre_ring import TyreRing
from vehicle_models.tyre_signal import TyreSignalSource

RING = TyreRing()
START = 10_000_000_000


def tyre_messages(drive: Drive, wheel: str, seed: int) -> list[tuple[int, TyreSignals]]:
    source = TyreSignalSource(RING, wheel_seed=7 if "rear" in wheel else 5, noise_seed=seed)
    time = np.arange(0.0, drive.time[-1], 1e-4)
    f = drive.forces
    fx, fz = (f.fx_rear, f.fz_rear) if "rear" in wheel else (f.fx_front, f.fz_front)
    block = source.advance(*(np.interp(time, drive.time, h) for h in (drive.speed / RING.radius, fx, fz)))
    found = []
    for first in range(0, len(time), 5000):
        part = slice(first, first + 5000)
        stamp = START + first * 100_000
        message = TyreSignals(
            header=Header(stamp=from_nanoseconds(stamp), frame_id=wheel),
            wheel=wheel,
            sample_rate=1e4,
            first_sample=first,
            encoder_voltage=array("f", block.encoder_voltage[part].tobytes()),
            radial_acceleration=array("f", block.radial_acceleration[part].tobytes()),
        )
        found.append((stamp, message))
    return found


def write(bag: Path, drive: Drive, seed: int) -> Path:
    store = get_typestore(Stores.ROS2_JAZZY)
    definition = Path(get_package_share_directory("friction_msgs"), "msg", "TyreSignals.msg").read_text()
    store.register(get_types_from_msg(definition, "friction_msgs/msg/TyreSignals"))
    rng = np.random.default_rng(seed)
    with Writer(bag, version=9) as writer:
        imu = writer.add_connection("/imu/data", "sensor_msgs/msg/Imu", typestore=store)
        for i in range(0, len(drive.time), 5):
            stamp = START + round(drive.time[i] * 1e9)
            felt = Vector3(x=float(drive.acceleration[i] + 0.1 * rng.standard_normal()))
            message = Imu(header=Header(stamp=from_nanoseconds(stamp)), linear_acceleration=felt)
            writer.write(imu, stamp, serialize_message(message))
        for k, wheel in enumerate(("front_left", "rear_left")):
            topic = f"/car/{wheel}/tyre_signals"
            tyre = writer.add_connection(topic, "friction_msgs/msg/TyreSignals", typestore=store)
            for stamp, message in tyre_messages(drive, wheel, seed + k):
                writer.write(tyre, stamp, serialize_message(message))
    return bag


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    base = tmp_path_factory.mktemp("bags")
    up, down = quasi_static_drives(road_seed=1)
    return {
        "up": write(base / "up", up, 10),
        "down": write(base / "down", down, 20),
        "dynamic": write(base / "dynamic", dynamic_drive(road_seed=3), 30),
    }


def test_bags_become_a_calibration_that_the_processor_can_use(bags: dict[str, Path], tmp_path: Path) -> None:
    out = tmp_path / "calibration.yaml"
    arguments = ["--quasi-static", str(bags["up"]), str(bags["down"]), "--dynamic", str(bags["dynamic"])]
    assert main([*arguments, "--out", str(out), "--plots", str(tmp_path / "plots")]) == 0
    assert {p.name for p in (tmp_path / "plots").iterdir()} == {"quasi_static_maps.png", "force_maps.png"}
    known = Calibration.load(out)
    assert set(known.wheels) == {"front_left", "rear_left"}
    assert known.tyre.beta == pytest.approx(RING.cross_talk, abs=0.04)
    # The edges jitter by 0.12; the load that changes between the two fronts adds some.
    assert np.degrees(known.tyre.jitter_stddev) == pytest.approx(0.13, abs=0.04)
    assert known.template is not None and set(known.tyre.residuals) >= {"shift_trend_rad", "length_map_rad"}

    drive = dynamic_drive(road_seed=40)
    for method in ("crossing", "template"):
        given = SmartTyreParameters(calibration_file=str(out), front_method=method)
        processor = build(given)[0]
        outputs: list[tuple[str, Any]] = []
        for _, message in tyre_messages(drive, "front_left", 50):
            outputs += processor.process("front_left/tyre_signals", message)
        forces = [m for topic, m in outputs if topic == "front_left/tyre_force" and m.valid]
        stamps = np.array([m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec - 1e-9 * START for m in forces])
        assert len(forces) > 350
        for found, truth, limit in (
            ([m.fz for m in forces], drive.forces.fz_front, 0.025),
            ([m.fx for m in forces], drive.forces.fx_front, 0.06),
        ):
            error = np.array(found) - np.interp(stamps, drive.time, truth)
            assert np.sqrt(np.mean(error**2)) < limit * RING.static_load


def test_bags_that_do_not_allow_it_are_named(
    bags: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = ["--out", str(tmp_path / "c.yaml")]
    assert main(["--quasi-static", str(tmp_path / "no_bag"), "--dynamic", str(bags["dynamic"]), *out]) == 2
    assert "no_bag" in capsys.readouterr().err
    assert main(["--quasi-static", str(bags["up"]), "--dynamic", str(bags["down"]), *out]) == 2
    assert capsys.readouterr().err.startswith("error: ")
    wrong_imu = ["--imu-topic", "imu/other"]
    assert main(["--quasi-static", str(bags["up"]), "--dynamic", str(bags["dynamic"]), *out, *wrong_imu]) == 2
    assert "imu/other" in capsys.readouterr().err
    assert not (tmp_path / "c.yaml").exists()
