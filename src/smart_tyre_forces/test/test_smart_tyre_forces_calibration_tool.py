"""The calibration tool on bags of a simulated car."""

from array import array
from pathlib import Path
from shutil import copytree
from typing import Any

import numpy as np
import pytest
import yaml
from ament_index_python.packages import get_package_share_directory
from friction_msgs.msg import TyreSignals
from geometry_msgs.msg import Vector3
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from sensor_msgs.msg import Imu
from std_msgs.msg import Header

from corner_sim.smart_tyre.drives import Drive, dynamic_drive, quasi_static_drives
from corner_sim.smart_tyre.tyre_ring import TyreRing
from corner_sim.smart_tyre.tyre_signal import TyreSignalSource
from friction_runtime.messages import from_nanoseconds
from smart_tyre_forces.calibration import Calibration
from smart_tyre_forces.parameters import SmartTyreParameters
from smart_tyre_forces.ros.calibration_tool import main
from smart_tyre_forces.ros.processor import build
from vehicle_models.vehicle_file import load_vehicle, vehicle_path

CAR = ["--vehicle", "smart_tyre_car"]
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


def noted(bag: Path, copy: Path, vehicle: str) -> str:
    """A bag again, with a note of its car."""
    copytree(bag, copy)
    metadata = yaml.safe_load((copy / "metadata.yaml").read_text())
    metadata["rosbag2_bagfile_information"]["custom_data"] = {"vehicle": vehicle}
    (copy / "metadata.yaml").write_text(yaml.safe_dump(metadata))
    return str(copy)


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
    dynamic = noted(bags["dynamic"], tmp_path / "noted", "smart_tyre_car")
    arguments = ["--quasi-static", str(bags["up"]), str(bags["down"]), "--dynamic", dynamic]
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
        processor = build(given, load_vehicle("smart_tyre_car"))[0]
        outputs: list[tuple[str, Any]] = []
        for _, message in tyre_messages(drive, "front_left", 50):
            outputs += processor.process("front_left/tyre_signals", message)
        forces = [m for topic, m in outputs if topic == "front_left/tyre_force" and m.validity.valid]
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
    out = ["--out", str(tmp_path / "c.yaml"), *CAR]
    assert main(["--quasi-static", str(tmp_path / "no_bag"), "--dynamic", str(bags["dynamic"]), *out]) == 2
    assert "no_bag" in capsys.readouterr().err
    assert main(["--quasi-static", str(bags["up"]), "--dynamic", str(bags["down"]), *out]) == 2
    assert capsys.readouterr().err.startswith("error: ")
    wrong_imu = ["--imu-topic", "imu/other"]
    assert main(["--quasi-static", str(bags["up"]), "--dynamic", str(bags["dynamic"]), *out, *wrong_imu]) == 2
    assert "imu/other" in capsys.readouterr().err
    assert not (tmp_path / "c.yaml").exists()


def test_drives_that_are_alike_are_refused_by_what_they_lack(
    bags: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    slow = [str(bags["up"]), str(bags["down"])]
    arguments = ["--quasi-static", *slow, "--dynamic", str(bags["up"]), str(bags["up"])]
    assert main([*arguments, "--out", str(tmp_path / "c.yaml"), *CAR]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "braking below -2.0 m/s^2 (for the force maps)" in said and said.startswith("error: the 4 dynamic drives")
    assert not (tmp_path / "c.yaml").exists()


def test_bags_whose_car_is_not_known_are_refused(
    bags: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = ["--out", str(tmp_path / "c.yaml")]
    plain = [str(bags["up"]), str(bags["down"])]
    assert main(["--quasi-static", *plain, "--dynamic", str(bags["dynamic"]), *out]) == 2
    assert "--vehicle" in capsys.readouterr().err
    own = tmp_path / "own.yaml"
    own.write_text(vehicle_path("smart_tyre_car").read_text().replace("front_left", "FL"))
    other = noted(bags["dynamic"], tmp_path / "other", str(own))
    assert main(["--quasi-static", *plain, "--dynamic", other, *out]) == 2
    assert "'front_left' is not a wheel of the car, which has FL, " in capsys.readouterr().err
    dynamic = noted(bags["dynamic"], tmp_path / "noted", "smart_tyre_car")
    assert main(["--quasi-static", *plain, "--dynamic", other, dynamic, *out]) == 2
    assert "different cars" in capsys.readouterr().err
    assert not (tmp_path / "c.yaml").exists()
