"""The car with which a bag is processed, and the messages where the two do not fit."""

from pathlib import Path

import pytest
from friction_msgs.msg import TyreSignals
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import JointState

from friction_bags.__main__ import main
from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.bag_writer import write_bag
from friction_bags.bag_io.cdr import decode
from friction_bags.offline.estimators import WHEEL_ESTIMATORS
from friction_bags.offline.plan import ProcessOptions
from friction_bags.offline.run import process_bag
from friction_parameters.parameter import ParameterError
from friction_runtime.installed import message_class
from friction_runtime.messages import from_nanoseconds
from vehicle_models.vehicle_file import shipped_vehicles

RADII = {"small": 0.25, "medium": 0.3, "large": 0.35}
NO_IMU = "/**/wheel_slip:\n  ros__parameters: {use_imu: false}\n"


def vehicle_file(path: Path, radius: float, *wheels: str) -> str:
    """A car whose joints are named otherwise than its wheels."""
    sides = (("front", "left"), ("front", "right"))
    lines = [
        f"  {wheel}: {{axle: {axle}, side: {side}, joint: 'car::{wheel}'}}"
        for wheel, (axle, side) in zip(wheels or ("FL", "FR"), sides, strict=False)
    ]
    common = f"all_wheels: {{radius: {radius}, inertia: 1.0, brake_gain: 1.0e-4}}"
    path.write_text("\n".join([f"name: {path.stem}", "mass: 450.0", common, "wheels:", *lines]))
    return str(path)


@pytest.fixture
def cars(tmp_path: Path) -> dict[str, str]:
    """Vehicle files of two wheels each, which differ in the radius."""
    return {name: vehicle_file(tmp_path / f"{name}.yaml", radius) for name, radius in RADII.items()}


def rolling(
    bag: Path, notes: dict[str, str], joints: tuple[str, ...] = ("car::FL", "steering", "car::FR"), sensor: bool = True
) -> Path:
    """A bag of a second of rolling at 12 m/s on wheels of 0.3 m, with a speed sensor or without."""
    messages = []
    for index in range(1, 201):
        stamp = from_nanoseconds(index * 5_000_000)
        states = JointState(name=list(joints), velocity=[40.0] * len(joints))
        speed = TwistWithCovarianceStamped()
        speed.twist.twist.linear.x = 12.0
        for topic, message in (("/vehicle_velocity", speed), ("/wheel_states", states)):
            message.header.stamp = stamp
            if sensor or topic == "/wheel_states":
                messages.append((topic, message))
    write_bag(bag, messages, notes)
    return bag


def rim_speed(bag: Path) -> float:
    """Last vehicle speed [m/s] that wheel_slip gave at the first wheel: 40 rad/s times the radius."""
    found = 0.0
    with BagReader(bag) as reader:
        for topic, _, data in reader.messages():
            if topic.name == "/FL/slip":
                found = float(decode(data, message_class(topic.type)).vehicle_speed)
    return found


@pytest.fixture
def no_imu(tmp_path: Path) -> Path:
    path = tmp_path / "no_imu"
    path.write_text(NO_IMU)
    return path


@pytest.mark.parametrize(
    ("given", "noted", "by_files", "chosen"),
    [
        ("small", "medium", "large", "small"),
        ("", "medium", "large", "medium"),
        ("", "medium", "", "medium"),
        ("", "", "large", "large"),
    ],
)
def test_the_car_is_that_of_the_command_else_of_the_bag_else_of_the_parameter_files(
    tmp_path: Path,
    cars: dict[str, str],
    no_imu: Path,
    capsys: pytest.CaptureFixture[str],
    given: str,
    noted: str,
    by_files: str,
    chosen: str,
) -> None:
    bag = rolling(tmp_path / "bag", {"vehicle": cars[noted]} if noted else {}, sensor=False)
    file = tmp_path / "parameters"
    file.write_text(f"/**:\n  ros__parameters: {{vehicle_file: {cars[by_files]}}}\n" if by_files else "")
    command = ["process", str(bag), "--out", str(tmp_path / "out"), "--estimators", "wheel_slip", "--jobs", "1"]
    command += ["--params-file", str(no_imu), "--params-file", str(file)]
    assert main([*command, *(["--vehicle", cars[given]] if given else [])]) == 0
    assert rim_speed(tmp_path / "out") == pytest.approx(40.0 * RADII[chosen], rel=0.02)
    with BagReader(tmp_path / "out") as reader:
        assert reader.custom_data["vehicle"] == cars[chosen]
    passed_over = bool(noted and by_files and not given)
    assert ("large.yaml' of the parameter files needs --vehicle" in capsys.readouterr().err) == passed_over


def test_without_a_car_the_shipped_ones_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = rolling(tmp_path / "bag", {})
    assert main(["process", str(bag), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert all(text in said for text in (str(bag), "--vehicle", *shipped_vehicles()))
    assert not (tmp_path / "out").exists()


def test_a_car_that_is_not_there_is_named_with_who_asked_for_it(tmp_path: Path) -> None:
    noted = rolling(tmp_path / "noted", {"vehicle": "/elsewhere/car.yaml"})
    with pytest.raises(ParameterError, match=r"note 'vehicle' of .*noted.*/elsewhere/car.yaml.*chapter_car"):
        process_bag(noted, tmp_path / "out", ProcessOptions(), 1, lambda _: None)
    with pytest.raises(ParameterError, match=r"--vehicle: .*chapter_cart.*chapter_car"):
        process_bag(noted, tmp_path / "out", ProcessOptions(vehicle="chapter_cart"), 1, lambda _: None)


def test_estimators_with_different_cars_are_refused(tmp_path: Path, cars: dict[str, str]) -> None:
    bag, file = rolling(tmp_path / "bag", {}), tmp_path / "parameters"
    file.write_text(
        f"/**/wheel_slip:\n  ros__parameters: {{vehicle_file: {cars['small']}}}\n"
        f"/**/friction_slope:\n  ros__parameters: {{vehicle_file: {cars['large']}}}\n"
    )
    with pytest.raises(ParameterError, match=r"wheel_slip has .*small.*friction_slope has .*large"):
        process_bag(bag, tmp_path / "out", ProcessOptions(parameter_files=(file,)), 1, lambda _: None)


def test_a_car_of_which_the_bag_holds_no_wheel_is_refused_with_the_names_of_both(tmp_path: Path) -> None:
    bag = rolling(tmp_path / "bag", {"vehicle": "chapter_car"})
    with pytest.raises(BagError, match=r"wheel_states holds car::FL, steering, car::FR.*chapter car.*front_left"):
        process_bag(bag, tmp_path / "out", ProcessOptions(), 1, lambda _: None)
    tyres = TyreSignals(wheel="FL")
    write_bag(tmp_path / "tyres", [("/FL/tyre_signals", tyres)], {"vehicle": "smart_tyre_car"})
    with pytest.raises(BagError, match=r"\*/tyre_signals holds FL.*smart tyre car.*front_left"):
        process_bag(tmp_path / "tyres", tmp_path / "out", ProcessOptions(), 1, lambda _: None)


@pytest.mark.parametrize("processes", [1, 2])
def test_a_wheel_that_is_missing_in_the_bag_is_named_with_the_names_there_are(
    tmp_path: Path, cars: dict[str, str], no_imu: Path, capfd: pytest.CaptureFixture[str], processes: int
) -> None:
    bag = rolling(tmp_path / "bag", {"vehicle": cars["medium"]}, ("car::FL", "car::fr"))
    options = ProcessOptions(WHEEL_ESTIMATORS, parameter_files=(no_imu,))
    process_bag(bag, tmp_path / "out", options, processes, lambda _: None)
    assert "no velocity for wheel 'FR' (joint 'car::FR'), names are: \"car::FL, car::fr\"" in capfd.readouterr().err
    assert rim_speed(tmp_path / "out") == pytest.approx(12.0, rel=0.02)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("/**/wheel_slip:\n  ros__parameters: {use_imu: true, use_imu: false}\n", "'use_imu' is repeated here"),
        ("/**/wheel_slip:\n  ros__parameters: {use_imus: true}\n", "unknown parameter 'use_imus'"),
        ("/**/wheel_slips:\n  ros__parameters: {use_imu: true}\n", "is '/**/wheel_slip' meant"),
        ("/other/wheel_slip:\n  ros__parameters: {use_imu: true}\n", "is not for the node /wheel_slip"),
        ("/**/wheel_slip:\n  ros__parameters: {deadline: -1.0}\n", "'deadline' = -1.0 s is outside"),
        ("wheel_slip: [", "not YAML"),
    ],
)
def test_parameter_files_are_checked_as_the_nodes_do(
    tmp_path: Path, cars: dict[str, str], text: str, said: str
) -> None:
    bag, file = rolling(tmp_path / "bag", {"vehicle": cars["medium"]}), tmp_path / "parameters"
    file.write_text(text)
    options = ProcessOptions(("wheel_slip",), parameter_files=(file,))
    with pytest.raises(ParameterError) as caught:
        process_bag(bag, tmp_path / "out", options, 1, lambda _: None)
    assert said in str(caught.value)
    assert str(file) in str(caught.value)


def test_sections_are_those_of_the_namespace(tmp_path: Path, cars: dict[str, str]) -> None:
    bag, file = rolling(tmp_path / "bag", {"vehicle": cars["medium"]}), tmp_path / "parameters"
    file.write_text("/car/wheel_slip:\n  ros__parameters: {use_imu: false}\n")
    options = ProcessOptions(("wheel_slip",), parameter_files=(file,), namespace="/car")
    with pytest.raises(BagError, match="holds no /car/wheel_states"):
        process_bag(bag, tmp_path / "out", options, 1, lambda _: None)


def test_parameters_of_another_method_are_ignored_and_that_is_said_once(
    tmp_path: Path, cars: dict[str, str], capfd: pytest.CaptureFixture[str]
) -> None:
    bag, file = rolling(tmp_path / "bag", {"vehicle": cars["medium"]}), tmp_path / "parameters"
    file.write_text(
        "/**/abs_supervisor:\n  ros__parameters: {pressure: {release_torque: 10.0}}\n" + NO_IMU, encoding="utf-8"
    )
    process_bag(bag, tmp_path / "out", ProcessOptions(parameter_files=(file,)), 2, lambda _: None)
    assert capfd.readouterr().err.count("abs_supervisor: pressure.release_torque: ignored") == 1


@pytest.mark.parametrize("shadow", [None, True, False])
def test_the_supervisor_writes_commands_only_where_a_parameter_file_says_so(
    tmp_path: Path, cars: dict[str, str], shadow: bool | None
) -> None:
    bag, file = rolling(tmp_path / "bag", {"vehicle": cars["medium"]}), tmp_path / "parameters"
    file.write_text(
        "" if shadow is None else f"/**/abs_supervisor:\n  ros__parameters: {{shadow: {str(shadow).lower()}}}\n"
    )
    process_bag(bag, tmp_path / "out", ProcessOptions(parameter_files=(file,)), 1, lambda _: None)
    with BagReader(tmp_path / "out") as reader:
        names = {topic.name for topic in reader.counts}
    assert {"/FL/abs_supervisor", "/FR/abs_supervisor"} <= names
    assert any(name.endswith("brake_command") for name in names) == (shadow is False)


def test_the_recorder_refuses_a_car_that_is_not_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["record", "--out", str(tmp_path / "bag"), "--vehicle", "no_car", "--duration", "0.1"]) == 2
    assert "no_car" in capsys.readouterr().err
    assert not (tmp_path / "bag").exists()


def test_info_shows_the_car(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rolling(tmp_path / "bag", {"vehicle": "chapter_car"})
    assert main(["info", str(tmp_path / "bag")]) == 0
    assert "vehicle: chapter_car" in capsys.readouterr().out
