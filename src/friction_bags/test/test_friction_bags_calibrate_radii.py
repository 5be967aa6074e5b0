"""The wheel radii from the coasting of a bag, written into a vehicle file."""

from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import JointState

from friction_bags.__main__ import main
from friction_bags.bag_io.message_bag import write_bag
from friction_bags.offline.vehicle_text import with_radii
from friction_runtime.stamps import from_nanoseconds
from vehicle_models.vehicle import Deviation, SharedBy
from vehicle_models.vehicle_file import load_vehicle

TRUE = np.array([0.301, 0.299, 0.304, 0.3035])
FOUR = ["front_left", "front_right", "rear_left", "rear_right"]
CAR = """\
name: my car   # it is mine
mass: {value: 1620.0, stddev: 60.0}
front_load_share: 0.58
wheelbase: 2.68
centre_of_gravity_height: 0.54
track: 1.55
all_wheels:
  inertia: 1.1
  radius: {value: 0.3, stddev: 0.005}    # from the data sheet
  brake_gain: 1.0e-4
wheels:
  front_left: {axle: front, side: left, }
  front_right: {axle: front, side: right, radius: 0.302}    # worn
  rear_left:
    # the new one
    axle: rear
    side: left
    radius:
      value: 0.305
      # a comment below
    driven: true
  rear_right: {axle: rear, side: right, radius: {stddev: 0.1, value: 0.3015}}
"""


def write_coasting(bag: Path, seconds: float, notes: dict[str, str], offset: float = 0.0) -> None:
    messages = []
    generator = np.random.default_rng(2)
    for k in range(round(seconds / 0.005)):
        stamp, speed = (k + 1) * 5_000_000, 20.0 - 0.5 * 0.005 * k
        omega = speed / TRUE + 0.07 * generator.normal(size=4)
        wheels = JointState(name=FOUR, velocity=omega.tolist())
        wheels.header.stamp = from_nanoseconds(stamp)
        messages.append(("/wheel_states", wheels))
        if k % 20 == 0:
            sensor = TwistWithCovarianceStamped()
            sensor.header.stamp = from_nanoseconds(stamp)
            sensor.twist.twist.linear.x = speed + offset
            messages.append(("/vehicle_velocity", sensor))
    write_bag(bag, messages, notes)


@pytest.fixture
def car(tmp_path: Path) -> Path:
    path = tmp_path / "my_car.yaml"
    path.write_text(CAR)
    return path


def test_tool_writes_the_radii_into_the_vehicle_file(
    tmp_path: Path, car: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_coasting(tmp_path / "bag", 6.0, {})
    out = tmp_path / "calibrated.yaml"
    assert main(["calibrate_radii", str(tmp_path / "bag"), "--vehicle", str(car), "--out", str(out)]) == 0
    assert load_vehicle(out).radii == pytest.approx(tuple(TRUE), abs=2e-4)
    for wheel in load_vehicle(out).wheels:
        assert 1e-6 <= wheel.deviations["radius"].stddev < 1e-3
        assert wheel.deviations["radius"].shared_by is SharedBy.WHEEL
    assert "rear_right" in capsys.readouterr().out
    assert car.read_text() == CAR


def test_everything_else_in_the_vehicle_file_stays_comments_too(tmp_path: Path, car: Path) -> None:
    changed = with_radii(CAR, dict.fromkeys(FOUR, (0.33, 0.0004)))
    expected = (
        CAR.replace("left: {axle: front", "left: {radius: {value: 0.33000, stddev: 0.000400}, axle: front")
        .replace("0.302}", "{value: 0.33000, stddev: 0.000400}}")
        .replace("value: 0.305", "stddev: 0.000400\n      value: 0.33000")
        .replace("{stddev: 0.1, value: 0.3015}", "{stddev: 0.000400, value: 0.33000}")
    )
    assert changed == expected
    (tmp_path / "changed.yaml").write_text(changed)
    before, after = load_vehicle(car), load_vehicle(tmp_path / "changed.yaml")
    assert after.radii == (0.33,) * 4
    for old, new in zip(before.wheels, after.wheels, strict=True):
        assert new.deviations == {**old.deviations, "radius": Deviation(0.0004, SharedBy.WHEEL)}
        assert (new.name, new.joint, new.inertia, new.driven) == (old.name, old.joint, old.inertia, old.driven)
    assert (after.mass, after.deviations) == (before.mass, before.deviations)


def test_radii_that_no_wheel_has_are_not_written(tmp_path: Path, car: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_coasting(tmp_path / "bag", 6.0, {}, offset=200.0)
    out = tmp_path / "calibrated.yaml"
    assert main(["calibrate_radii", str(tmp_path / "bag"), "--vehicle", str(car), "--out", str(out)]) == 2
    assert "'radius' = " in capsys.readouterr().err
    assert not out.exists()


def test_the_car_may_be_that_of_the_bag_and_the_latency_of_the_sensor_that_of_a_parameter_file(
    tmp_path: Path, car: Path
) -> None:
    write_coasting(tmp_path / "bag", 6.0, {"vehicle": str(car)}, offset=0.5 * 0.2)
    parameters = tmp_path / "parameters.yaml"
    parameters.write_text("/**/wheel_slip:\n  ros__parameters: {speed_sensor: {latency: 0.2}}\n")
    command = ["calibrate_radii", str(tmp_path / "bag"), "--params-file", str(parameters)]
    assert main([*command, "--out", str(tmp_path / "calibrated.yaml")]) == 0
    assert load_vehicle(tmp_path / "calibrated.yaml").radii == pytest.approx(tuple(TRUE), abs=2e-4)


def test_against_each_other_the_wheels_keep_their_mean_radius(tmp_path: Path, car: Path) -> None:
    write_coasting(tmp_path / "bag", 6.0, {})
    command = ["calibrate_radii", str(tmp_path / "bag"), "--vehicle", str(car), "--against", "wheels"]
    assert main([*command, "--out", str(tmp_path / "calibrated.yaml")]) == 0
    radii = np.array(load_vehicle(tmp_path / "calibrated.yaml").radii)
    assert radii / radii.mean() == pytest.approx(TRUE / TRUE.mean(), rel=1e-3)
    assert radii.mean() == pytest.approx(np.mean(load_vehicle(car).radii), rel=2e-3)


def test_tool_says_what_is_missing(tmp_path: Path, car: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_coasting(tmp_path / "short", 1.0, {})
    out = tmp_path / "radii.yaml"
    assert main(["calibrate_radii", str(tmp_path / "short"), "--vehicle", str(car), "--out", str(out)]) == 1
    assert "coasting" in capsys.readouterr().err
    assert main(["calibrate_radii", str(tmp_path / "absent"), "--out", str(out)]) == 2
    assert "absent" in capsys.readouterr().err
    assert main(["calibrate_radii", str(tmp_path / "short"), "--out", str(out)]) == 2
    assert "--vehicle" in capsys.readouterr().err
    assert not out.exists()
