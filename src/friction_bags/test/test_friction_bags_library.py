from pathlib import Path

import numpy as np
import pytest
from friction_msgs.msg import SupervisorState, TyreForce, WheelSlip

from friction_bags.__main__ import main
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode, message_definition
from friction_bags.experiments import tyre_runs
from friction_bags.experiments.library import EXPERIMENTS, START_STAMP, simulate
from friction_bags.experiments.stops import STOPS
from friction_bags.experiments.stops import simulate as simulate_stop
from vehicle_models import burckhardt
from vehicle_models.constants import GRAVITY
from vehicle_models.surfaces import SURFACES
from vehicle_models.vehicle_file import load_vehicle

BAGS = Path(__file__).parents[3] / "bags"


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
    run = tyre_runs.TyreRun("short", True, 2e5, (0.5, 1.0))
    longer = tyre_runs.TyreRun("longer", True, 2e5, (0.0, 1.5))
    cut = list(tyre_runs.simulate(run, START_STAMP, full=False))
    whole = list(tyre_runs.simulate(longer, START_STAMP, full=False))
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
        ours = [topic for topic in reader.counts if topic.type.startswith("friction_msgs/")]
        assert all(topic.definition == message_definition(topic.type).text for topic in ours), "run `make bags`"
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
