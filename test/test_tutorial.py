"""The tutorial of the README, command by command: a log becomes a car that is known, and estimates that are right."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import friction_bags.__main__
from corner_sim.car.car_parameters import WHEELS
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import decode
from friction_bags.experiments.tutorial import PRESSURE_AGE, SMALL_WHEEL, drive
from friction_runtime.installed import message_class
from friction_runtime.messages import to_nanoseconds
from vehicle_doctor.__main__ import main as doctor
from vehicle_models.vehicle_file import load_vehicle

pytest.importorskip("can", reason="python-can is absent: python3 -m pip install python-can cantools")
pytest.importorskip("cantools")

STOP = 6_000_000_000
"""The end of the drive with its hard stop [ns]: estimates of the whole take a minute."""


def bags(*arguments: object) -> int:
    return friction_bags.__main__.main([str(each) for each in arguments])


def last_part(bag: Path, out: Path) -> Path:
    with BagReader(bag) as reader:
        messages = list(reader.messages())
        notes = dict(reader.custom_data)
    begin = messages[-1][1] - STOP
    with BagWriter(out, custom_data=notes) as writer:
        channels: dict[Any, int] = {}
        for topic, stamp, data in messages:
            if stamp >= begin:
                if topic not in channels:
                    channels[topic] = writer.add_topic(topic)
                writer.write(channels[topic], stamp, data)
    return out


def estimates(stop: Path, vehicle: Path, out: Path) -> dict[str, list[Any]]:
    """Messages by topic of slips and curves."""
    only = ("--estimators", "wheel_slip", "friction_curve_id", "--outputs-only", "--jobs", 1)
    assert bags("process", stop, "--vehicle", vehicle, "--out", out, *only) == 0
    found: dict[str, list[Any]] = {}
    with BagReader(out) as reader:
        for topic, _, data in reader.messages():
            found.setdefault(topic.name, []).append(decode(data, message_class(topic.type)))
    return found


def test_the_doctor_learns_the_car_of_the_log_and_its_estimates_become_right(tmp_path: Path) -> None:
    car = tmp_path / "tutorial"
    assert bags("tutorial", "--out", car) == 0
    assert bags("import", car / "drive.blf", "--map", car / "map.yaml", "--out", car / "bag") == 0
    learned, file = car / "learned.yaml", tmp_path / "findings.json"
    assert doctor([str(car / "bag"), "--write", str(learned), "--json", str(file)]) == 1

    alarms = {
        (each["check"], each["subject"])
        for each in json.loads(file.read_text())["findings"]
        if each["verdict"] in ("WARN", "FAIL")
    }
    assert alarms == {("radius", "front_left"), *(("skew", f"{wheel}/brake_pressure") for wheel in WHEELS)}
    vehicle = load_vehicle(learned)
    assert vehicle.radii == pytest.approx((0.3 * SMALL_WHEEL, 0.3, 0.3, 0.3), rel=3e-3)
    assert vehicle.brake_pressure_delay == pytest.approx(PRESSURE_AGE, abs=2e-3)

    truth = drive()
    lambda_max, mu_max = truth.lambda_max[0], truth.mu_max[-1, 0]
    stop = last_part(car / "bag", car / "stop")
    before = estimates(stop, car / "my_car.yaml", car / "before")
    after = estimates(stop, learned, car / "after")
    error = {}
    for name, found in (("before", before), ("after", after)):
        slips = [each for each in found["/front_left/slip"] if each.validity.valid]
        times = [1e-9 * (to_nanoseconds(each.header.stamp) - 1_700_000_000_000_000_000) for each in slips]
        true = np.interp(times, truth.time, truth.slip[:, 0])
        error[name] = float(np.sqrt(np.mean((np.array([each.slip for each in slips]) - true) ** 2)))
    assert max(error.values()) < 0.004, "wheel_slip corrects the radius itself"
    for wheel in WHEELS:
        told = before[f"/{wheel}/friction_curve"]
        claimed = [each for each in told if each.validity.valid]
        assert len(claimed) < 0.02 * len(told)
        assert all(abs(each.lambda_max - lambda_max) < 1.96 * each.lambda_max_stddev for each in claimed)
        assert all(abs(each.mu_max - mu_max) < 1.96 * each.mu_max_stddev for each in claimed)
        curve = after[f"/{wheel}/friction_curve"][-1]
        assert curve.validity.valid
        assert abs(curve.lambda_max - lambda_max) < min(2.0 * curve.lambda_max_stddev, 0.1 * lambda_max)
        assert abs(curve.mu_max - mu_max) < min(2.0 * curve.mu_max_stddev, 0.05 * mu_max)
        # what a tyre may have of its own is in them: 5 % of lambda_max; 3 % of mu_max, and 10 % of the load moved
        assert curve.lambda_max_stddev < np.hypot(0.05, 0.052) * lambda_max
        assert curve.mu_max_stddev < 0.07 * mu_max


def test_a_directory_that_exists_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert bags("tutorial", "--out", tmp_path) == 2
    assert "exists" in capsys.readouterr().err
