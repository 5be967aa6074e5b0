from array import array
from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import TyreSignals
from sensor_msgs.msg import Imu
from std_msgs.msg import Header

from corner_sim.smart_tyre.tyre_signal import AccelerometerParameters, TyreBlock
from friction_parameters.generated import parameter_file
from friction_parameters.parameter import ParameterError, from_mapping
from friction_parameters.parameter_file import load
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from friction_runtime.processor import Level
from smart_tyre_forces.calibration import Calibration, TyreCalibration, WheelCalibration
from smart_tyre_forces.car_reference import Reference
from smart_tyre_forces.force_map import ForceMap
from smart_tyre_forces.parameters import SHIPPED, SmartTyreParameters
from smart_tyre_forces.ros.processor import TyreProcessor, build
from smart_tyre_forces.tooth_table import ToothTable
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle
from vehicle_models.wheel_forces import drag, wheel_forces

CAR = load_vehicle("smart_tyre_car")
CONFIG = Path(__file__).parents[1] / "config" / "smart_tyre_forces.yaml"
TOPIC = "front_left/tyre_signals"


def blocks(block: TyreBlock, size: int = 100, start: int = 5_000_000_000) -> Iterator[TyreSignals]:
    for first in range(0, len(block.encoder_voltage), size):
        part = slice(first, first + size)
        yield TyreSignals(
            header=Header(stamp=from_nanoseconds(start + first * 100_000), frame_id="front_left_wheel"),
            wheel="front_left",
            sample_rate=1e4,
            first_sample=first,
            encoder_voltage=array("f", block.encoder_voltage[part].tobytes()),
            radial_acceleration=array("f", block.radial_acceleration[part].tobytes()),
            inflation_pressure=2e5,
        )


def feed(processor: TyreProcessor, messages: Iterable[TyreSignals | Imu]) -> list[tuple[str, Any]]:
    fed = [("imu/data" if isinstance(message, Imu) else TOPIC, message) for message in messages]
    return [output for topic, message in fed for output in processor.process(topic, message)]


@pytest.fixture
def calibration_file(table: ToothTable, tmp_path: Path) -> str:
    tyre = TyreCalibration(
        shift_trend=(0.0, 9e-4, 2e-6),
        length_trend=(0.43, -1e-4, -2e-5),
        nominal_length=0.427,
        beta=0.08,
        jitter_stddev=2e-3,
        load_scatter=0.0,
        length_map=ForceMap((0.1, 9.6e-5, -2.1e-9), 2500.0, 4800.0),
        shift_map=ForceMap((0.0, 1.3e-5), -4000.0, 2200.0),
        trend_force=(0.0, -0.1, 0.065),
    )
    wheel = WheelCalibration(tuple(float(d) for d in table.deviations), (0.0, 0.0, 0.0))
    Calibration(tyre, {"front_left": wheel}).save(tmp_path / "calibration.yaml")
    return str(tmp_path / "calibration.yaml")


def test_shipped_parameters_are_the_defaults() -> None:
    assert load(SmartTyreParameters, CONFIG, "smart_tyre_forces") == SmartTyreParameters()
    assert CONFIG.read_text() == parameter_file("smart_tyre_forces", SHIPPED["smart_tyre_forces"])


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"front_method": "guess"}, "front_method"),
        ({"front_method": "template"}, "calibration_file"),
        ({"tracker": {"minimum_speed": 20.0, "maximum_speed": 10.0}}, "maximum_speed"),
        ({"tracker.sample_rate": -1.0}, "tracker.sample_rate"),
        ({"zero.duration": 0.0}, "zero.duration"),
    ],
)
def test_bad_parameters_are_refused_by_name(values: dict[str, Any], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        from_mapping(SmartTyreParameters, values)


def changed(**values: Any) -> Vehicle:
    """The car with other front left wheel."""
    first, *others = CAR.wheels
    return replace(CAR, wheels=(replace(first, **values), *others))


def test_calibration_that_does_not_fit_is_refused(calibration_file: str, tmp_path: Path) -> None:
    given = SmartTyreParameters(calibration_file=calibration_file)
    with pytest.raises(ValueError, match=r"calibration\.yaml: has front_left, no wheel of the car: FL, front_right"):
        build(given, changed(name="FL"))
    with pytest.raises(ValueError, match="teeth"):
        build(given, changed(encoder_teeth=60))
    with pytest.raises(ValueError, match="template"):
        build(replace(given, front_method="template"), CAR)
    with pytest.raises(ValueError, match="calibration_file"):
        build(SmartTyreParameters(calibration_file=str(tmp_path / "none.yaml")), CAR)


def test_wheels_that_the_calibration_lacks_give_raw_patches_and_say_so_once_they_have_signals(
    simulate: Any, calibration_file: str
) -> None:
    said: list[str] = []
    processors = build(
        SmartTyreParameters(calibration_file=calibration_file), CAR, lambda _severity, text: said.append(text)
    )
    watched = [["imu/data", *(f"{wheel}/brake_pressure" for wheel in CAR.wheel_names)], [], [], []]
    assert [list(each.optional) for each in processors] == [
        [f"{wheel}/tyre_signals", *car] for wheel, car in zip(CAR.wheel_names, watched, strict=True)
    ]
    assert said == []
    messages = list(blocks(simulate(10.0, seconds=14.0)))
    for message in messages:
        message.wheel = "rear_right"
    outputs = [output for each in messages for output in processors[3].process("rear_right/tyre_signals", each)]
    processors[3].reset()
    processors[3].process("rear_right/tyre_signals", messages[0])
    assert said == [f"calibration file {calibration_file}: no wheel 'rear_right': raw contact patches only"]
    last = [m for topic, m in outputs if topic == "rear_right/contact_patch"][-1]
    assert last.validity.reason == Reason.NOT_CALIBRATED and np.isfinite(last.length_raw)


def test_one_patch_and_one_force_a_revolution_and_a_wrench_on_request(simulate: Any, calibration_file: str) -> None:
    given = SmartTyreParameters(calibration_file=calibration_file, publish_wrench=True)
    block = simulate(8.0, seconds=7.0)
    outputs = feed(build(given, CAR)[0], blocks(block))
    patches = [m for topic, m in outputs if topic == "front_left/contact_patch"]
    forces = [m for topic, m in outputs if topic == "front_left/tyre_force"]
    wrenches = [m for topic, m in outputs if topic == "front_left/tyre_wrench"]
    revolutions = (block.wheel_angle[-1] - block.wheel_angle[0]) / (2.0 * np.pi)
    # The patch of the first revolutions may be cut by the start.
    assert revolutions - 3.0 < len(patches) < revolutions + 1.0
    assert [p.revolution for p in patches] == list(range(1, len(patches) + 1))
    assert all(p.validity.reason == Reason.NOT_READY and not p.validity.valid for p in patches[:10])
    for message in (*patches, *forces):
        assert message.validity.valid == (message.validity.text == "")
        assert message.validity.valid or message.validity.text.startswith("front_left: ")
    assert patches[-1].validity.valid and patches[-1].validity.reason == Reason.OK
    assert patches[-1].length == pytest.approx(patches[-1].alpha_2 - patches[-1].alpha_1, abs=0.02)
    assert [f.validity.valid for f in forces] == [p.validity.valid for p in patches]
    assert forces[0].validity.reason == Reason.NO_PATCH and np.isnan(forces[0].fx)
    assert len(wrenches) == sum(f.validity.valid for f in forces) > 0
    assert wrenches[-1].wrench.force.z == forces[-1].fz
    assert forces[-1].fz == pytest.approx(3679.0, rel=0.1)


def test_stamp_is_that_of_the_trailing_front(simulate: Any) -> None:
    block = simulate(10.0, seconds=14.0)
    outputs = feed(build(SmartTyreParameters(), CAR)[0], blocks(block))
    patches = [m for topic, m in outputs if topic == "front_left/contact_patch" and m.alpha_2 == m.alpha_2]
    assert patches
    level = 0.5 * (10.0 / 0.32) ** 2 * 0.32
    for patch in patches[-5:]:
        sample = (to_nanoseconds(patch.header.stamp) - 5_000_000_000) / 1e5
        around = block.radial_acceleration[int(sample) - 3 : int(sample) + 4]
        assert around[0] < level < around[-1]
        assert patch.header.frame_id == "front_left_wheel"


@pytest.mark.parametrize("size", [37, 500, 70_000])
def test_messages_of_any_block_size_give_the_same(simulate: Any, calibration_file: str, size: int) -> None:
    given = SmartTyreParameters(calibration_file=calibration_file)
    block = simulate(8.0, seconds=7.0)
    expected = feed(build(given, CAR)[0], blocks(block))
    assert repr(feed(build(given, CAR)[0], blocks(block, size))) == repr(expected)


def test_uncalibrated_wheel_gives_raw_patches_and_says_so(simulate: Any) -> None:
    outputs = feed(build(SmartTyreParameters(), CAR)[0], blocks(simulate(10.0, seconds=14.0)))
    last = [m for topic, m in outputs if topic == "front_left/contact_patch"][-1]
    assert last.validity.reason == Reason.NOT_CALIBRATED and not last.validity.valid
    assert np.degrees(last.length_raw) == pytest.approx(24.5, abs=1.5)
    assert np.isnan(last.length_stddev)
    force = [m for topic, m in outputs if topic == "front_left/tyre_force"][-1]
    assert force.validity.reason == Reason.NOT_CALIBRATED and np.isnan(force.fz)


def test_garbage_is_refused_by_topic_and_leaves_the_state_intact(simulate: Any, calibration_file: str) -> None:
    said: list[str] = []
    given = SmartTyreParameters(calibration_file=calibration_file)
    messages = list(blocks(simulate(8.0, seconds=7.0)))
    expected = feed(build(given, CAR)[0], messages)
    processor = build(given, CAR, lambda severity, text: said.append(text))[0]
    outputs = feed(processor, messages[:300])
    good = messages[300]
    wrong_wheel, wrong_rate, uneven, empty, zero, late = (TyreSignals(**_fields(good)) for _ in range(6))
    wrong_wheel.wheel = "rear_left"
    wrong_rate.sample_rate = float("nan")
    uneven.encoder_voltage = array("f", [0.0])
    empty.encoder_voltage, empty.radial_acceleration = array("f"), array("f")
    zero.header, late.header = Header(), Header(stamp=from_nanoseconds((2**31 - 1) * 10**9))
    for bad in (messages[299], wrong_wheel, wrong_rate, uneven, empty, zero, late):
        assert processor.process(TOPIC, bad) == []
    assert repr(outputs + feed(processor, messages[300:])) == repr(expected)
    assert len(said) == 7 and all(TOPIC in text for text in said)


def _fields(message: TyreSignals) -> dict[str, Any]:
    return {name: getattr(message, name) for name in message.get_fields_and_field_types()}


@pytest.mark.parametrize(("rear", "share"), [(6e6, 0.65), (0.0, 1.0), (12e6, 0.4815)])
def test_braked_wheels_share_by_gain_times_pressure(rear: float, share: float) -> None:
    """By the gains alone where the pressures are alike; ABS or a slow rise make them differ."""
    pressures = {wheel: 6e6 if wheel.startswith("front") else rear for wheel in CAR.wheel_names}
    torques = {wheel: CAR.wheel(wheel).brake_gain * pressure for wheel, pressure in pressures.items()}
    references = {wheel: Reference(CAR, CAR.wheel(wheel)) for wheel in CAR.wheel_names}
    forces = {wheel: reference.share(20.0, -5.0, torques) for wheel, reference in references.items()}
    sum_of = wheel_forces(CAR, 20.0, -5.0)
    assert sum(force for force in forces.values() if force) == pytest.approx(2.0 * (sum_of.fx_front + sum_of.fx_rear))
    rolling = CAR.rolling_resistance * float(sum_of.fz_front)
    braking = CAR.mass * 5.0 - drag(CAR, 20.0) - CAR.rolling_resistance * CAR.mass * 9.81
    assert 2.0 * (-float(forces["front_left"] or 0.0) - rolling) / braking == pytest.approx(share, abs=0.001)


def test_share_of_a_braked_wheel_is_not_known_without_the_pressures_of_all() -> None:
    reference = Reference(CAR, CAR.wheel("front_left"))
    assert reference.share(20.0, -5.0, {"front_left": 500.0}) is None
    assert reference.share(20.0, 1.0, {}) == pytest.approx(float(wheel_forces(CAR, 20.0, 1.0).fx_front))


def test_scatter_of_the_fronts_in_the_shipped_calibration_is_that_of_the_plant() -> None:
    """The load that changes while the sensor crosses the patch is told apart from it."""
    tyre = Calibration.load(CONFIG.parents[1] / "calibration" / "plant_tyres.yaml").tyre
    assert tyre.jitter_stddev == pytest.approx(AccelerometerParameters().edge_jitter, rel=0.05)
    assert tyre.load_scatter > 0.0


def test_time_that_goes_back_starts_again(simulate: Any, calibration_file: str) -> None:
    given = SmartTyreParameters(calibration_file=calibration_file)
    messages = list(blocks(simulate(8.0, seconds=7.0)))
    said: list[tuple[str, str]] = []
    processor = build(given, CAR, lambda severity, text: said.append((severity, text)))[0]
    first, second = feed(processor, messages), feed(processor, messages)
    assert repr(first) == repr(second)
    assert said == [("info", f"{TOPIC}: stamps jumped back, front_left starts again")]


def test_health_says_what_is_missing(simulate: Any, calibration_file: str) -> None:
    processor = build(SmartTyreParameters(calibration_file=calibration_file), CAR)[0]
    feed(processor, list(blocks(simulate(8.0, seconds=7.0)))[:3])
    assert (processor.health().level, processor.health().message) == (Level.OK, "no revolution seen yet")
    feed(processor, blocks(simulate(8.0, seconds=7.0)))
    assert processor.health().level is Level.OK
    processor.watch({TOPIC: 1.0}, 0.0)
    assert processor.health().level is Level.ERROR
    processor.watch({TOPIC: 0.0}, 0.0)
    processor.request_length_zero()
    feed(processor, blocks(simulate(8.0, seconds=3.0), start=20_000_000_000))
    assert (processor.health().level, processor.health().message[:11]) == (Level.OK, "no zero yet")


def test_health_warns_of_a_wheel_that_nobody_calibrated(simulate: Any) -> None:
    processor = build(SmartTyreParameters(), CAR)[0]
    feed(processor, blocks(simulate(10.0, seconds=14.0)))
    assert (processor.health().level, processor.health().message[:14]) == (Level.WARN, "not calibrated")


def test_wheel_without_signals_is_no_fault_but_one_whose_signals_end_is(simulate: Any) -> None:
    said: list[str] = []
    processor = build(SmartTyreParameters(), CAR, lambda _severity, text: said.append(text))[0]
    processor.watch({TOPIC: inf}, 0.0)
    assert (processor.health().level, processor.health().message) == (Level.OK, "no tyre signals")
    assert said == []
    feed(processor, list(blocks(simulate(8.0, seconds=7.0)))[:3])
    processor.watch({TOPIC: 1.0}, 0.0)
    assert processor.health().level is Level.ERROR
    processor.reset()
    processor.watch({TOPIC: 2.0}, 0.0)
    assert processor.health().level is Level.ERROR


def test_pressure_change_is_reported_once(simulate: Any, calibration_file: str) -> None:
    said: list[str] = []
    given = SmartTyreParameters(calibration_file=calibration_file)
    processor = build(given, CAR, lambda severity, text: said.append(text))[0]
    # A tenth more load lengthens the patch by 7 %, as 1.6 bar does.
    feed(processor, blocks(simulate(8.0, seconds=14.0, load=1.1)))
    assert len([text for text in said if "pressure" in text]) == 1


@pytest.mark.parametrize("first_sample", [2**53, 2**60, 2**64 - 1])
def test_block_whose_samples_cannot_be_told_apart_by_number_is_refused_and_the_next_ones_are_not_lost(
    simulate: Any, calibration_file: str, first_sample: int
) -> None:
    block = simulate(8.0, seconds=7.0)
    said: list[str] = []
    parameters = SmartTyreParameters(calibration_file=calibration_file)
    processor = build(parameters, CAR, lambda _, text: said.append(text))[0]
    clean = feed(build(parameters, CAR)[0], blocks(block))
    assert clean
    messages = list(blocks(block))
    hostile = next(blocks(block))
    hostile.first_sample = first_sample
    hostile.header.stamp = from_nanoseconds(to_nanoseconds(messages[3].header.stamp) + 1)
    assert repr(feed(processor, [*messages[:4], hostile, *messages[4:]])) == repr(clean)
    assert [text for text in said if str(first_sample) in text]


@pytest.mark.parametrize(("voltage", "acceleration"), [(3e38, 0.0), (0.0, 3e38), (-3e38, -3e38)])
def test_what_no_sensor_gives_is_no_patch_and_no_warning_of_numpy(
    simulate: Any, calibration_file: str, voltage: float, acceleration: float
) -> None:
    block = simulate(8.0, seconds=7.0)
    processor = build(SmartTyreParameters(calibration_file=calibration_file), CAR)[0]
    messages = list(blocks(block))
    for message in messages[5:8]:
        message.encoder_voltage[3] += voltage
        message.radial_acceleration[7] += acceleration
    with np.errstate(all="raise"):
        answers = feed(processor, messages)
    assert answers


def test_answers_do_not_depend_on_whether_the_acceleration_or_the_block_came_first(
    simulate: Any, calibration_file: str
) -> None:
    messages = list(blocks(simulate(8.0, seconds=14.0, load=1.1)))
    stamps = range(5_000_000_000, 19_000_000_000, 5_000_000)
    sensed = [Imu(header=Header(stamp=from_nanoseconds(stamp))) for stamp in stamps]
    both = sorted([*messages, *sensed], key=lambda m: to_nanoseconds(m.header.stamp))
    # Blocks arrive when they are over, accelerations up to a quarter of a second late.
    late = sorted(
        [*messages, *sensed],
        key=lambda m: to_nanoseconds(m.header.stamp) + (250_000_000 if isinstance(m, Imu) else 10_000_000),
    )
    given = SmartTyreParameters(calibration_file=calibration_file)
    learned, other, alone = (feed(build(given, CAR)[0], each) for each in (both, late, messages))
    assert repr(learned) == repr(other)
    assert repr(learned) != repr(alone)
    last = [[m for topic, m in each if topic == "front_left/tyre_force"][-1] for each in (learned, alone)]
    # What carries a tenth more than its static load is a tyre that reads too much, or so it looks to the watch.
    assert last[0].fz == pytest.approx(3679.0, rel=0.03) and last[0].fz_stddev < 0.2 * last[1].fz_stddev
