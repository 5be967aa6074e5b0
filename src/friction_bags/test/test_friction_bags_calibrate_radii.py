"""The wheel radii from the coasting of a bag, as a parameter file."""

from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import JointState

from friction_bags.__main__ import main
from friction_bags.message_bag import write_bag
from friction_runtime.parameters import load
from friction_runtime.stamps import from_nanoseconds
from wheel_slip.parameters import WheelSlipParameters

TRUE = np.array([0.301, 0.299, 0.304, 0.3035])
FOUR = ["front_left", "front_right", "rear_left", "rear_right"]


def write_coasting(bag: Path, seconds: float) -> None:
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
            sensor.twist.twist.linear.x = speed
            messages.append(("/vehicle_velocity", sensor))
    write_bag(bag, messages, {})


def test_tool_writes_a_parameter_file_that_loads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_coasting(tmp_path / "bag", 6.0)
    nominal = tmp_path / "nominal.yaml"
    nominal.write_text(f"/**/wheel_slip:\n  ros__parameters:\n    wheels: [{', '.join(FOUR)}]\n")
    out = tmp_path / "radii.yaml"
    assert main(["calibrate_radii", str(tmp_path / "bag"), "--out", str(out), "--parameters", str(nominal)]) == 0
    assert load(WheelSlipParameters, out, "wheel_slip").radii == pytest.approx(tuple(TRUE), abs=2e-4)
    assert "rear_right" in capsys.readouterr().out


def test_tool_says_what_is_missing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_coasting(tmp_path / "short", 1.0)
    out = tmp_path / "radii.yaml"
    nominal = tmp_path / "nominal.yaml"
    nominal.write_text(f"/**/wheel_slip:\n  ros__parameters:\n    wheels: [{', '.join(FOUR)}]\n")
    assert main(["calibrate_radii", str(tmp_path / "short"), "--out", str(out), "--parameters", str(nominal)]) == 1
    assert "coasting" in capsys.readouterr().err
    assert main(["calibrate_radii", str(tmp_path / "absent"), "--out", str(out)]) == 2
    assert "absent" in capsys.readouterr().err
    assert not out.exists()
