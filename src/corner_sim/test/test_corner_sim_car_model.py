"""`model: car`: the independent car behind the messages of the plant."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import BrakeCommand
from std_msgs.msg import Header

from corner_sim.car.tyres import TYRES
from corner_sim.car_plant import CarModelParameters
from corner_sim.parameters import SimParameters
from corner_sim.ros import messages
from corner_sim.ros.simulation import Simulation
from friction_runtime.command_checksum import sealed
from friction_runtime.messages import from_nanoseconds
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

START = 10**18
COMPACT = load_vehicle("compact_car")
QUIET = SimParameters(model="car", noise="none", demand_start=0.0, demand_level=0.6, initial_speed=25.0)


def run(
    parameters: SimParameters,
    samples: int,
    vehicle: Vehicle = COMPACT,
    act: Callable[[Simulation], None] | None = None,
) -> dict[str, list[Any]]:
    simulation = Simulation(parameters, vehicle, START)
    found: dict[str, list[Any]] = {}
    for k in range(samples):
        if k:
            if act is not None:
                act(simulation)
            simulation.advance()
        for topic, message in simulation.messages():
            found.setdefault(topic, []).append(message)
    return found


def release(simulation: Simulation, wheel: str, command: int) -> None:
    header = Header(stamp=from_nanoseconds(simulation.stamp))
    order = sealed(BrakeCommand(header=header, wheel=wheel, command=command, counter=simulation.index, valid_for=0.1))
    assert simulation.take_command(wheel, order) is None


def test_the_topics_are_those_of_the_other_models_and_the_yaw_moment() -> None:
    found = set(run(QUIET, 3))
    assert found == {*run(replace(QUIET, model="single_corner"), 3), "truth/yaw_moment"}
    told = messages.topics(COMPACT.wheel_names, True, True, False, yaw_moment=True)
    assert found == set(told)


def test_another_surface_under_the_right_wheels_has_its_own_tyres_and_turns_the_car() -> None:
    """To the left, where the wheels have grip: half the track times what the left wheels brake more."""
    split = replace(QUIET, surfaces=("dry",), demand_level=0.9, car=CarModelParameters(right_surface="snow"))
    found, even = run(split, 100), run(replace(split, car=CarModelParameters()), 100)
    peaks = [found[f"truth/{wheel}/friction_curve"][0].lambda_max for wheel in COMPACT.wheel_names]
    dry, snow = (TYRES["burckhardt"][name].peak[0] for name in ("dry", "snow"))
    assert peaks == [dry, snow, dry, snow]
    forces = np.array([found[f"truth/{wheel}/tyre_force"][-1].fx for wheel in COMPACT.wheel_names])
    lever = 0.5 * COMPACT.track * np.array([1.0, -1.0, 1.0, -1.0])
    moment = found["truth/yaw_moment"][-1].wrench.torque.z
    assert moment == pytest.approx(-float(lever @ forces))
    assert moment > 1000.0
    assert even["truth/yaw_moment"][-1].wrench.torque.z == pytest.approx(0.0, abs=1e-6)


def test_tyres_air_and_rolling_slow_the_car_by_their_sum_and_load_moves_to_the_front() -> None:
    found = run(QUIET, 200)
    forces = [found[f"truth/{wheel}/tyre_force"][-1] for wheel in COMPACT.wheel_names]
    speed = found["truth/vehicle_velocity"][-1].twist.twist.linear.x
    resistance = 0.012 * sum(force.fz for force in forces) + 0.5 * 1.2 * 0.65 * speed**2
    acceleration = COMPACT.accelerometer.forward(found["imu/data"][-1].linear_acceleration)
    assert 1500.0 * acceleration == pytest.approx(sum(force.fx for force in forces) - resistance, rel=1e-3)
    moved = forces[0].fz + forces[1].fz - forces[2].fz - forces[3].fz
    assert moved == pytest.approx(-2.0 * 1500.0 * acceleration * 0.5 / 2.7, rel=0.01)


@pytest.mark.parametrize("family", TYRES)
def test_the_true_curve_is_that_of_the_tyre_of_the_family_on_the_road(family: str) -> None:
    parameters = replace(QUIET, surfaces=("wet",), car=CarModelParameters(tyre=family), demand_level=1.4)
    found = run(parameters, 200)
    curve = found["truth/rear_left/friction_curve"][-1]
    assert (curve.lambda_max, curve.mu_max) == pytest.approx(TYRES[family]["wet"].peak)
    assert np.isnan(curve.theta_1) == (family == "pacejka")
    slope = found["truth/rear_left/friction_slope"][-1]
    assert slope.crossings == 1
    assert slope.slip_at_crossing == pytest.approx(TYRES[family]["wet"].peak[0])
    assert slope.crossing_stamp.sec * 10**9 + slope.crossing_stamp.nanosec > START
    assert curve.probability_beyond_peak == 1.0


def test_without_load_transfer_and_relaxation_it_moves_as_the_corners_do() -> None:
    wheels = tuple(replace(wheel, relaxation_length=1e-3) for wheel in COMPACT.wheels)
    plain = replace(COMPACT, wheels=wheels, centre_of_gravity_height=0.0, rolling_resistance=0.0, drag_area=0.0)
    parameters = replace(QUIET, demand_rise=0.3, demand_level=0.9)
    ours, theirs = (run(replace(parameters, model=model), 300, plain) for model in ("car", "single_corner"))
    for wheel in COMPACT.wheel_names:
        slips = [np.array([message.slip for message in found[f"truth/{wheel}/slip"]]) for found in (ours, theirs)]
        np.testing.assert_allclose(slips[0], slips[1], atol=2e-3)
    speeds = [found["truth/vehicle_velocity"][-1].twist.twist.linear.x for found in (ours, theirs)]
    assert speeds[0] == pytest.approx(speeds[1], abs=0.02)


def test_the_rear_axle_meets_a_new_road_one_wheelbase_later() -> None:
    rolling = replace(QUIET, demand_level=0.0, surfaces=("dry", "snow"), surface_distances=(0.0, 5.0))
    found = run(rolling, 80)
    changed = {
        wheel: next(k for k, curve in enumerate(found[f"truth/{wheel}/friction_curve"]) if curve.restarts)
        for wheel in COMPACT.wheel_names
    }
    front, rear = changed["front_left"], changed["rear_right"]
    assert front == pytest.approx(5.0 / 0.125, abs=1) and rear - front == pytest.approx(2.7 / 0.125, abs=1)


def test_a_brake_obeys_its_own_command() -> None:
    found = run(QUIET, 60, act=lambda simulation: release(simulation, "rear_left", BrakeCommand.DECREASE))
    pressures = {wheel: found[f"{wheel}/brake_pressure"][-1].fluid_pressure for wheel in COMPACT.wheel_names}
    assert pressures["rear_left"] == 0.0
    assert pressures["rear_right"] > 1e6


def test_slip_of_the_tyre_follows_that_of_the_wheel_over_the_relaxation_length_of_the_vehicle_file() -> None:
    slips = []
    for length in (0.01, 0.6):
        wheels = tuple(replace(wheel, relaxation_length=length) for wheel in COMPACT.wheels)
        found = run(replace(QUIET, demand_rise=0.2), 30, replace(COMPACT, wheels=wheels))
        slip, curve = found["truth/front_left/slip"][-1].slip, found["truth/front_left/friction_curve"][-1].slip
        slips.append((slip, curve))
    (short, short_tyre), (long, long_tyre) = slips
    assert short_tyre == pytest.approx(short, rel=0.05)
    assert long_tyre < 0.9 * long


@pytest.mark.parametrize("encoder", [False, True])
def test_wheel_speeds_come_from_the_encoder_if_asked(encoder: bool) -> None:
    found = run(replace(QUIET, demand_level=0.3, car=CarModelParameters(encoder=encoder)), 200)
    measured = np.array([message.velocity[0] for message in found["wheel_states"]])
    truth = np.array([message.wheel_speed for message in found["truth/front_left/slip"]])
    assert np.abs(measured[5:] - truth[5:]).max() < 0.5
    assert (np.abs(measured - truth).max() < 1e-9) != encoder


def test_noise_and_road_repeat_with_the_seed() -> None:
    parameters = replace(
        QUIET, noise="chapter", acceleration_variance=0.01, car=CarModelParameters(load_variation=0.05)
    )
    first, again, other = (run(each, 20) for each in (parameters, parameters, replace(parameters, seed=3)))
    assert repr(first) == repr(again)
    for topic in ("wheel_states", "rear_left/brake_pressure", "imu/data", "truth/front_left/tyre_force"):
        assert repr(first[topic]) != repr(other[topic]), topic


def test_perturbations_of_sensors_and_road_reach_the_messages() -> None:
    plain = run(QUIET, 60)
    perturbations = CarModelParameters(slope=0.05, acceleration_delay=0.01, wheel_delay=0.005)
    found = run(replace(QUIET, demand_level=0.0, car=perturbations, acceleration_bias=0.2), 60)
    # on a slope the accelerometer feels what gravity does not take: the drag alone, and its offset
    assert found["imu/data"][-1].linear_acceleration.x == pytest.approx(0.2 - 0.28, abs=0.03)
    late = run(replace(QUIET, car=CarModelParameters(wheel_delay=0.005)), 60)
    assert late["wheel_states"][40].velocity[2] == pytest.approx(plain["wheel_states"][39].velocity[2])


def test_a_hill_begins_where_it_is_told_to_and_is_felt_by_the_accelerometer_as_gravity_is_not() -> None:
    hill = CarModelParameters(hill=0.06, hill_distance=8.0, hill_length=10.0)
    assert [hill.hill_at(each) for each in (0.0, 8.0, 13.0, 18.0, 500.0)] == pytest.approx([0.0, 0.0, 0.03, 0.06, 0.06])
    rolls = replace(QUIET, demand_level=0.0)
    plain, found = run(rolls, 200), run(replace(rolls, car=hill), 200)
    speeds = [each["truth/front_left/slip"][-1].vehicle_speed for each in (plain, found)]
    # 8 m at QUIET's speed, then 10 m of a rise, then the full slope
    speed = QUIET.initial_speed
    lost = 9.81 * 0.06 * (1.0 - 13.0 / speed)
    assert speeds[0] - speeds[1] == pytest.approx(lost, rel=0.15)
    readings = [each["imu/data"][-1].linear_acceleration.x for each in (plain, found)]
    assert readings[0] == pytest.approx(readings[1], abs=0.03)


def test_a_stop_ends_at_standstill() -> None:
    simulation = Simulation(replace(QUIET, initial_speed=10.0), COMPACT, START)
    for _ in range(800):
        simulation.advance()
        if simulation.end is not None:
            break
    assert simulation.speed == 0.0
    assert all(np.isnan(dict(simulation.messages())[f"truth/{wheel}/slip"].slip) for wheel in COMPACT.wheel_names)


@pytest.mark.parametrize(
    ("parameters", "vehicle", "text"),
    [
        (QUIET, "chapter_corner", "'model' = 'car': .*four wheels"),
        (replace(QUIET, surfaces=("off_road",)), "compact_car", "'surfaces': .* not off_road"),
        (
            replace(QUIET, car=CarModelParameters(right_surface="off_road")),
            "compact_car",
            "'car.right_surface': .* not off_road",
        ),
        (replace(QUIET, initial_speed=0.0), "compact_car", "'initial_speed' = 0.0 m/s"),
    ],
)
def test_what_the_model_cannot_do_is_refused(parameters: SimParameters, vehicle: str, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        Simulation(parameters, load_vehicle(vehicle), START)
