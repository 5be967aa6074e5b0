"""A run behind its messages."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import BrakeCommand, BrakeDemand
from std_msgs.msg import Header

from corner_sim.parameters import SimParameters
from corner_sim.ros import messages
from corner_sim.ros.simulation import Simulation
from friction_runtime.command_checksum import sealed
from friction_runtime.messages import from_nanoseconds, to_nanoseconds
from vehicle_models import burckhardt
from vehicle_models.reason import Reason
from vehicle_models.surfaces import surface
from vehicle_models.vehicle import Accelerometer, Vehicle
from vehicle_models.vehicle_file import load_vehicle

START = 1_000_000_000
CORNER = load_vehicle("chapter_corner")
FOUR_CORNERS = load_vehicle("chapter_car")
Supervisor = Callable[[int], int]


def with_gains(vehicle: Vehicle, *gains: float) -> Vehicle:
    wheels = zip(vehicle.wheels, gains, strict=True)
    return replace(vehicle, wheels=tuple(replace(wheel, brake_gain=gain) for wheel, gain in wheels))


def run(
    parameters: SimParameters, samples: int, supervisor: Supervisor | None = None, vehicle: Vehicle = CORNER
) -> dict[str, list[Any]]:
    """Messages by topic of the first samples, under a supervisor that maps sample number to command."""
    simulation = Simulation(parameters, vehicle, START)
    found: dict[str, list[Any]] = {}
    for k in range(samples):
        for topic, message in simulation.messages():
            found.setdefault(topic, []).append(message)
        if supervisor is not None:
            header = Header(stamp=from_nanoseconds(simulation.stamp))
            for wheel in vehicle.wheel_names:
                order = sealed(
                    BrakeCommand(header=header, wheel=wheel, command=supervisor(k), counter=k, valid_for=0.1)
                )
                assert simulation.take_command(wheel, order) is None
        simulation.advance()
    return found


def cycling(k: int) -> int:
    return int(BrakeCommand.DECREASE if k % 60 > 40 else BrakeCommand.INCREASE)


def test_every_topic_carries_every_sample_with_the_stamps_of_the_schedule() -> None:
    found = run(SimParameters(), 30, vehicle=FOUR_CORNERS)
    topics = messages.topics(FOUR_CORNERS.wheel_names, vehicle_velocity=True, brake_demand=True, tyre_signals=False)
    assert set(found) == set(topics)
    for topic, list_of_messages in found.items():
        stamps = [to_nanoseconds(message.header.stamp) for message in list_of_messages]
        assert stamps == [START + 5_000_000 * k for k in range(30)], topic
        assert all(message.__class__ is topics[topic] for message in list_of_messages), topic


def test_topics_that_are_not_wanted_are_not_published() -> None:
    found = run(SimParameters(vehicle_velocity=False, demand_source="topic"), 2)
    assert "vehicle_velocity" not in found
    assert "brake_demand" not in found


def test_the_same_seed_repeats_every_message_and_another_seed_does_not() -> None:
    first, again = run(SimParameters(), 300, cycling), run(SimParameters(), 300, cycling)
    other = run(SimParameters(seed=1), 300, cycling)
    assert repr(first) == repr(again)  # repr, because NaN is not equal to itself
    assert repr(first["wheel_states"]) != repr(other["wheel_states"])
    assert repr(first["truth/front_left/slip"]) == repr(other["truth/front_left/slip"])


def test_pressure_times_gain_is_the_torque_that_slows_wheel_and_vehicle() -> None:
    found = run(SimParameters(noise="none", demand_start=0.0), 60, vehicle=with_gains(CORNER, 2e-4))
    speed = np.array([m.twist.twist.linear.x for m in found["vehicle_velocity"]])
    wheel_speed = np.array([m.velocity[0] for m in found["wheel_states"]])
    torque = 2e-4 * np.array([m.fluid_pressure for m in found["front_left/brake_pressure"]])
    impulse = (0.5 * (torque[1:] + torque[:-1]) * 0.005).sum()
    momentum = (wheel_speed[-1] - wheel_speed[0]) + 0.3 * 225.0 * (speed[-1] - speed[0])
    assert wheel_speed[-1] > 0.0
    assert momentum == pytest.approx(-impulse, rel=1e-6)


def test_demand_is_a_multiple_of_the_peak_torque_of_the_first_surface() -> None:
    parameters = SimParameters(
        demand_level=1.5, demand_start=0.0, surfaces=("snow", "dry"), surface_distances=(0.0, 9.0)
    )
    lambda_max, mu_max = burckhardt.peak(surface("snow"))
    peak_torque = mu_max * (0.3 * 225.0 * 9.81 + (1.0 - lambda_max) * 9.81 / 0.3)
    pressure = run(parameters, 1)["brake_demand"][0].pressure
    assert pressure == pytest.approx(1.5 * peak_torque / 1e-4, rel=1e-12)


def test_demand_by_torque_is_that_torque_at_the_wheel() -> None:
    found = run(
        SimParameters(noise="none", demand_unit="torque", demand_level=300.0, demand_start=0.0),
        40,
        vehicle=with_gains(CORNER, 2e-4),
    )
    assert found["front_left/brake_pressure"][-1].fluid_pressure * 2e-4 == pytest.approx(300.0)


def test_the_topic_brakes_when_it_is_the_source() -> None:
    simulation = Simulation(SimParameters(noise="none", demand_source="topic"), CORNER, START)
    assert simulation.take_demand(BrakeDemand(pressure=2e6)) is None
    for _ in range(20):
        simulation.advance()
    pressure = {topic: m for topic, m in simulation.messages() if topic == "front_left/brake_pressure"}
    assert pressure["front_left/brake_pressure"].fluid_pressure == pytest.approx(2e6)


def test_release_by_command_lets_the_wheel_spin_up_again() -> None:
    locked = run(SimParameters(noise="none"), 260)["truth/front_left/slip"][-1]
    released = run(SimParameters(noise="none"), 260, lambda k: BrakeCommand.DECREASE if k > 160 else BrakeCommand.NONE)[
        "truth/front_left/slip"
    ][-1]
    assert locked.slip == 1.0
    assert released.slip < 0.02


def test_the_imu_says_what_the_speed_does_and_no_more() -> None:
    found = run(SimParameters(noise="none", demand_level=0.5, demand_start=0.0), 100)
    speed = np.array([m.twist.twist.linear.x for m in found["truth/vehicle_velocity"]])
    acceleration = np.array([m.linear_acceleration.x for m in found["imu/data"]])
    np.testing.assert_allclose(acceleration[1:-1], (speed[2:] - speed[:-2]) / 0.01, atol=0.05)
    assert acceleration[-1] < -1.0
    assert found["imu/data"][0].orientation_covariance[0] == -1.0


def test_true_crossings_lie_at_lambda_max_between_the_samples_around_them() -> None:
    found = run(SimParameters(noise="none"), 330, cycling)
    lambda_max = float(burckhardt.peak(surface("dry"))[0])
    slips, slopes = found["truth/front_left/slip"], found["truth/front_left/friction_slope"]
    expected = [k for k in range(1, 330) if (slips[k].slip > lambda_max) != (slips[k - 1].slip > lambda_max)]
    assert len(expected) >= 3
    assert slopes[-1].crossings == len(expected)
    for number, k in enumerate(expected, start=1):
        assert slopes[k - 1].crossings == number - 1
        assert slopes[k].crossings == number
        assert slopes[k].slip_at_crossing == pytest.approx(lambda_max, rel=1e-12)
        assert slopes[k].crossing_sign == slopes[k].sign == (-1 if slips[k].slip > lambda_max else 1)
        crossing = to_nanoseconds(slopes[k].crossing_stamp)
        assert to_nanoseconds(slips[k - 1].header.stamp) <= crossing <= to_nanoseconds(slips[k].header.stamp)
    assert slopes[0].crossings == slopes[0].crossing_sign == 0


def test_the_true_indicator_has_the_sign_of_the_slope() -> None:
    for slope in run(SimParameters(noise="none"), 330, cycling)["truth/front_left/friction_slope"]:
        if abs(slope.indicator) > 1e-6:
            assert np.sign(slope.indicator) == slope.sign
            assert slope.method == "truth"


def test_a_change_of_surface_shows_in_the_true_curve_once() -> None:
    parameters = SimParameters(noise="none", demand_level=0.0, surfaces=("dry", "snow"), surface_distances=(0.0, 2.95))
    curves = run(parameters, 40)["truth/front_left/friction_curve"]
    assert [curve.restarts for curve in curves] == [0] * 20 + [1] * 20  # 2.95 m at 0.15 m a sample
    assert curves[19].theta_2 == surface("dry")[1]
    assert curves[20].theta_2 == surface("snow")[1]
    assert curves[39].lambda_max == pytest.approx(float(burckhardt.peak(surface("snow"))[0]))


def test_the_true_force_is_load_times_friction_and_negative_in_braking() -> None:
    found = run(SimParameters(noise="none", demand_start=0.0), 60)
    force, curve = found["truth/front_left/tyre_force"][-1], found["truth/front_left/friction_curve"][-1]
    assert force.fz == pytest.approx(225.0 * 9.81)
    assert force.fx == pytest.approx(-force.fz * curve.mu)
    assert force.fx < -1000.0


def test_at_standstill_the_truth_says_that_slip_is_not_defined() -> None:
    found = run(SimParameters(noise="none", initial_speed=2.0, demand_start=0.0), 300)
    slip, slope = found["truth/front_left/slip"][-1], found["truth/front_left/friction_slope"][-1]
    assert not slip.validity.valid
    assert slip.validity.reason == Reason.LOW_SPEED
    assert "front_left" in slip.validity.text
    assert np.isnan(slip.slip)
    assert not slope.validity.valid
    assert slope.sign == 0


@pytest.mark.parametrize(
    ("changes", "named"), [({"end_speed": 12.0}, "end_speed"), ({"end_time": 0.1}, "end_time"), ({}, "end_speed")]
)
def test_a_run_ends_at_its_speed_or_its_time(changes: dict[str, float], named: str) -> None:
    simulation = Simulation(SimParameters(**changes), CORNER, START)  # type: ignore[arg-type]
    while simulation.end is None:
        simulation.advance()
        assert simulation.index < 2000
    assert named in simulation.end
    if "end_time" in changes:
        assert simulation.index == 20
    else:
        assert simulation.speed <= changes.get("end_speed", 0.0)


def test_a_run_without_an_end_goes_on_at_standstill() -> None:
    simulation = Simulation(SimParameters(initial_speed=1.0, demand_start=0.0, end_speed=-1.0), CORNER, START)
    for _ in range(400):
        simulation.advance()
    assert simulation.speed == 0.0
    assert simulation.end is None


CAR = with_gains(FOUR_CORNERS, 1.6e-4, 1.6e-4, 0.8e-4, 0.8e-4)
BRAKING = SimParameters(model="car", noise="none", demand_start=0.0, demand_level=0.6)


def test_a_car_without_four_wheels_is_refused_with_those_it_has() -> None:
    with pytest.raises(ValueError, match=r"'model' = 'car': .*'chapter corner' are front_left \(front left\)"):
        Simulation(BRAKING, CORNER, START)


def test_the_wheels_of_a_car_may_stand_in_any_order_in_its_file() -> None:
    mixed = replace(CAR, wheels=tuple(CAR.wheels[k] for k in (2, 1, 3, 0)))
    found, same = run(BRAKING, 40, cycling, mixed), run(BRAKING, 40, cycling, CAR)
    assert repr(found) == repr(same)
    corners = run(replace(BRAKING, model="single_corner"), 2, vehicle=mixed)
    assert list(corners["wheel_states"][0].name) == ["rear_left", "front_right", "rear_right", "front_left"]


def test_wheel_states_name_the_joints_and_topics_the_wheels() -> None:
    joints = ("car::wheel_fl", "front-right", "rear_left", "4")
    wheels = tuple(replace(wheel, joint=joint) for wheel, joint in zip(CAR.wheels, joints, strict=True))
    found, plain = run(BRAKING, 5, cycling, replace(CAR, wheels=wheels)), run(BRAKING, 5, cycling, CAR)
    assert set(found) == set(plain)
    assert all(tuple(message.name) == joints for message in found["wheel_states"])
    assert [message.velocity for message in found["wheel_states"]] == [m.velocity for m in plain["wheel_states"]]


def test_the_imu_message_is_read_back_by_the_mounting_of_the_car() -> None:
    mounting = Accelerometer(axis="y", sign=-1.0, bias=0.3, scale=1.02, pitch_gain=0.004)
    parameters = replace(BRAKING, model="single_corner", acceleration_variance=0.0)
    found = run(parameters, 60, vehicle=replace(CAR, accelerometer=mounting))["imu/data"]
    plain = run(parameters, 60, vehicle=CAR)["imu/data"]
    for message, truth in zip(found, plain, strict=True):
        assert mounting.forward(message.linear_acceleration) == pytest.approx(truth.linear_acceleration.x, abs=1e-12)
        assert message.linear_acceleration.x == message.linear_acceleration.z == 0.0
    assert found[-1].linear_acceleration.y > 3.0
    noisy = run(replace(parameters, acceleration_variance=0.5), 1, vehicle=replace(CAR, accelerometer=mounting))
    assert list(noisy["imu/data"][0].linear_acceleration_covariance) == [0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0]


def test_the_pressure_of_a_late_sensor_is_that_of_its_delay_earlier() -> None:
    late, now = (
        run(replace(BRAKING, model="single_corner"), 60, cycling, replace(CAR, brake_pressure_delay=delay))[
            "rear_left/brake_pressure"
        ]
        for delay in (0.0075, 0.0)
    )
    pressure = [message.fluid_pressure for message in now]
    halfway = [0.5 * (pressure[k - 2] + pressure[k - 1]) for k in range(2, 60)]
    assert [message.fluid_pressure for message in late[2:]] == pytest.approx(halfway, rel=1e-12)
    assert [message.header.stamp for message in late] == [message.header.stamp for message in now]


def test_tyre_blocks_follow_each_other_without_gap_and_stop_where_the_sample_begins() -> None:
    found = run(SimParameters(tyre_signals=True, demand_level=0.0, noise="none"), 60)
    blocks = found["front_left/tyre_signals"]
    assert [to_nanoseconds(block.header.stamp) for block in blocks] == [START + 5_000_000 * k for k in range(59)]
    assert [block.first_sample for block in blocks] == [50 * k for k in range(59)]
    assert {len(block.encoder_voltage) for block in blocks} == {50}
    assert {len(block.radial_acceleration) for block in blocks} == {50}


def test_the_encoder_of_a_smart_tyre_turns_with_the_wheel() -> None:
    found = run(SimParameters(tyre_signals=True, demand_level=0.0, noise="none"), 201)
    voltage = np.concatenate([block.encoder_voltage for block in found["front_left/tyre_signals"]])
    rises = np.count_nonzero((voltage[:-1] < 0.0) & (voltage[1:] >= 0.0))
    assert rises == pytest.approx(48 * 100.0 / (2.0 * np.pi) * 1.0, abs=1.0)  # 48 teeth at 100 rad/s for 1 s


def test_the_encoder_of_a_smart_tyre_has_the_teeth_of_the_wheel() -> None:
    wheels = (replace(CORNER.wheels[0], encoder_teeth=96),)
    found = run(
        SimParameters(tyre_signals=True, demand_level=0.0, noise="none"), 101, vehicle=replace(CORNER, wheels=wheels)
    )
    voltage = np.concatenate([block.encoder_voltage for block in found["front_left/tyre_signals"]])
    rises = np.count_nonzero((voltage[:-1] < 0.0) & (voltage[1:] >= 0.0))
    assert rises == pytest.approx(96 * 100.0 / (2.0 * np.pi) * 0.5, abs=1.0)


def test_smart_tyres_repeat_with_their_seed() -> None:
    parameters = SimParameters(tyre_signals=True)
    first, again, other = (
        run(p, 20)["front_left/tyre_signals"] for p in (parameters, parameters, replace(parameters, seed=9))
    )
    assert first == again
    assert first != other
