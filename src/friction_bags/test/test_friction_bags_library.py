from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from friction_msgs.msg import SupervisorState, TyreForce, WheelSlip

from friction_bags import library_tyres
from friction_bags.__main__ import main
from friction_bags.bag_reader import BagReader
from friction_bags.cdr import decode
from friction_bags.library import EXPERIMENTS, START_STAMP, simulate
from friction_bags.library_stops import STOPS, SprungCar
from friction_bags.library_stops import simulate as simulate_stop
from vehicle_models import burckhardt
from vehicle_models.single_corner import GRAVITY
from vehicle_models.surfaces import SURFACES
from vehicle_models.vehicle_file import load_vehicle

BAGS = Path(__file__).parents[3] / "bags"
CAR = replace(load_vehicle("compact_car"), drag_area=0.0)
DRY = np.tile(SURFACES["dry"], (4, 1))


def test_the_load_settles_at_the_quasi_static_transfer_and_overshoots_on_the_way() -> None:
    car = SprungCar(CAR, 60.0)
    torque = np.full(4, 300.0)
    loads = []
    for _ in range(500):
        car.step(torque, torque, DRY, 0.005)
        loads.append(car.vertical_load(DRY))
    settled = np.asarray(loads[-1])
    weight = CAR.mass * GRAVITY
    assert settled.sum() == pytest.approx(weight)
    transfer = -CAR.mass * car.acceleration(DRY) * CAR.height_ratio
    assert settled[0] + settled[1] - 0.5 * weight == pytest.approx(transfer, rel=0.02)
    # a second-order system of damping z overshoots a step by exp(-pi z / sqrt(1 - z^2)) = 37 %
    highest = max(load[0] for load in loads) - 0.25 * weight
    assert 1.25 < highest / (settled[0] - 0.25 * weight) < 1.38


def test_the_contact_builds_up_its_slip_over_the_relaxation_length() -> None:
    ice = DRY * np.array([1e-9, 1.0, 1e-9])
    car = SprungCar(replace(CAR, wheels=tuple(replace(wheel, inertia=1e9) for wheel in CAR.wheels)), 20.0)
    car._state[1:5] *= 0.99
    time = CAR.wheels[0].relaxation_length / 20.0
    for _ in range(3):
        car.step(np.zeros(4), np.zeros(4), ice, time / 3.0)
    built_up = car._state[5:9]
    assert built_up == pytest.approx(np.full(4, 0.01 * (1.0 - np.exp(-1.0))), rel=1e-4)
    assert car.friction(DRY) == pytest.approx(burckhardt.friction(DRY, built_up))


def test_what_the_tyres_take_the_car_loses() -> None:
    car = SprungCar(CAR, 30.0)
    torque = np.array([500.0, 500.0, 200.0, 200.0])
    impulse = 0.0
    for _ in range(200):
        before = float(np.sum(car.vertical_load(DRY) * car.friction(DRY)))
        car.step(torque, torque, DRY, 0.001)
        impulse += 0.0005 * (before + float(np.sum(car.vertical_load(DRY) * car.friction(DRY))))
    assert CAR.mass * (30.0 - car.speed) == pytest.approx(impulse, rel=1e-3)


@pytest.mark.parametrize("name", list(STOPS))
def test_a_stop_passes_the_peak_and_its_apparent_friction_exceeds_the_curve(name: str) -> None:
    theta = SURFACES[STOPS[name].surface]
    peak_slip, peak_friction = (float(value) for value in burckhardt.peak(theta))
    car = load_vehicle("chapter_car")
    slips, apparent, actual, speeds = [], [], [], []
    for topic, message in simulate_stop(STOPS[name], START_STAMP):
        if topic == "/truth/front_left/slip":
            slips.append(message.slip)
            speeds.append(message.vehicle_speed)
        elif topic == "/truth/front_left/tyre_force":
            actual.append(-message.fx / message.fz)
            apparent.append(-message.fx)
    acceleration = np.gradient(speeds, 0.005)
    load = 0.5 * car.mass * (0.5 * GRAVITY - acceleration * car.height_ratio)
    assert peak_slip < max(slips) < 0.5
    assert max(actual) <= peak_friction + 1e-9
    assert max(np.asarray(apparent) / load) > 1.01 * peak_friction


@pytest.mark.parametrize("name", ["dry", "wet", "cobblestone", "snow"])
def test_a_ramp_passes_the_peak_of_its_surface(name: str) -> None:
    slips = [message.slip for topic, message in simulate(EXPERIMENTS[name]) if topic == "/truth/front_left/slip"]
    assert max(slips) > float(burckhardt.peak(SURFACES[name])[0])
    assert slips[-1] < 0.01


def test_the_loop_of_the_abs_stop_is_closed() -> None:
    states, last = set(), 0.0
    for topic, message in simulate(EXPERIMENTS["abs_stop"]):
        if topic == "/front_left/abs_supervisor":
            states.add(message.state)
        elif topic == "/truth/front_left/slip":
            last = message.vehicle_speed
    assert states >= {SupervisorState.S0, SupervisorState.S1, SupervisorState.S21, SupervisorState.S22}
    assert last == pytest.approx(5.0, abs=0.1)


def test_a_cut_of_a_tyre_run_is_a_part_of_it() -> None:
    run = library_tyres.TyreRun("short", True, 2e5, (0.5, 1.0))
    longer = library_tyres.TyreRun("longer", True, 2e5, (0.0, 1.5))
    cut = list(library_tyres.simulate(run, START_STAMP, full=False))
    whole = list(library_tyres.simulate(longer, START_STAMP, full=False))
    begin = next(index for index, each in enumerate(whole) if each == cut[0])
    assert isinstance(cut[0][1], TyreForce)
    assert [topic for topic, _ in cut] == [topic for topic, _ in whole[begin : begin + len(cut)]]
    assert cut[0] == whole[begin]
    assert cut[-1][1].header == whole[begin + len(cut) - 1][1].header


def test_the_same_command_makes_the_same_bytes_and_replaces_only_its_bags(tmp_path: Path) -> None:
    (tmp_path / "wet").mkdir()
    (tmp_path / "wet" / "thesis.txt").write_text("precious")
    for _ in range(2):
        assert main(["library", "--out", str(tmp_path), "snow"]) == 0
        content = (tmp_path / "snow" / "snow_0.mcap").read_bytes()
    assert main(["library", "--out", str(tmp_path / "again"), "snow"]) == 0
    assert (tmp_path / "again" / "snow" / "snow_0.mcap").read_bytes() == content
    assert main(["library", "--out", str(tmp_path), "wet"]) == 2
    assert (tmp_path / "wet" / "thesis.txt").read_text() == "precious"
    assert main(["library", "--out", str(tmp_path), "moon"]) == 2


@pytest.mark.parametrize("name", [path.name for path in sorted(BAGS.iterdir()) if path.is_dir()])
def test_the_bags_of_the_repository_are_sound_small_and_explained(name: str) -> None:
    with BagReader(BAGS / name) as reader:
        assert reader.custom_data["note"] in (BAGS / "README.md").read_text()
        assert load_vehicle(reader.custom_data["vehicle"])
        count = 0
        for topic, stamp, data in reader.messages():
            count += 1
            if topic.type == "friction_msgs/msg/WheelSlip":
                header = decode(data, WheelSlip).header
                assert header.stamp.sec * 10**9 + header.stamp.nanosec == stamp
        assert count == reader.message_count > 0
        assert reader.problems == []
    assert sum(file.stat().st_size for file in (BAGS / name).iterdir()) < 1_000_000
