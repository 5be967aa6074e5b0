"""The plant against closed forms, conservation laws and its own derivatives."""

from dataclasses import replace

import numpy as np
import pytest

from corner_sim.corner import JoinedCorners
from corner_sim.plant import SAMPLE_TIME, Plant
from corner_sim.road import Road
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.surfaces import SURFACES, surface
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

FOUR_CORNERS = load_vehicle("chapter_car")
CORNER = load_vehicle("chapter_corner").corner("front_left")
GAIN = 1e-4
IMMEDIATE = ActuatorParameters(delay=0.0, apply_rate=1e9, release_rate=1e9)


def corners(count: int) -> Vehicle:
    """A number of corners of the chapter: all four, or one or two at the front."""
    if count == 4:
        return FOUR_CORNERS
    return replace(FOUR_CORNERS, mass=225.0 * count, front_load_share=1.0, wheels=FOUR_CORNERS.wheels[:count])


def plant(
    count: int = 1, speed: float = 30.0, road: Road | None = None, actuator: ActuatorParameters = IMMEDIATE
) -> Plant:
    return plant_of(corners(count), speed, road, actuator)


def plant_of(
    vehicle: Vehicle,
    speed: float = 30.0,
    road: Road | None = None,
    actuator: ActuatorParameters = IMMEDIATE,
) -> Plant:
    model = JoinedCorners([vehicle.corner(name) for name in vehicle.wheel_names], speed)
    return Plant(model, road or Road(["dry"], [0.0]), actuator, vehicle)


def test_a_vehicle_that_nobody_brakes_keeps_its_speed() -> None:
    sut = plant()
    for _ in range(400):
        sut.advance(0.0, Command.NONE)
    sample = sut.sample()
    assert sample.speed == 30.0
    assert sample.wheel_speed[0] == 30.0 / CORNER.radius
    assert sample.distance == pytest.approx(60.0, abs=1e-9)
    assert sample.slip[0] == 0.0


@pytest.mark.parametrize("name", SURFACES)
def test_a_locked_wheel_slows_the_vehicle_by_g_mu_of_one(name: str) -> None:
    sut = plant(road=Road([name], [0.0]))
    while sut.sample().wheel_speed[0] > 0.0:
        sut.advance(3000.0 / GAIN, Command.NONE)
    before = sut.sample()
    for _ in range(50):
        sut.advance(3000.0 / GAIN, Command.NONE)
    after = sut.sample()
    th1, th2, th3 = surface(name)
    expected = CORNER.gravity * (th1 * (1.0 - np.exp(-th2)) - th3)
    # the implicit stages carry a trace (1e-5) of the blocked wheel's moment over to the vehicle
    assert (before.speed - after.speed) / (50 * SAMPLE_TIME) == pytest.approx(expected, rel=2e-5)
    travelled = (before.speed**2 - after.speed**2) / (2.0 * expected)
    assert after.distance - before.distance == pytest.approx(travelled, rel=2e-5)
    assert after.slip[0] == 1.0


def test_steady_braking_settles_at_the_slip_whose_friction_balances_the_torque() -> None:
    sut = plant()
    torque = 500.0
    for _ in range(100):
        sut.advance(torque / GAIN, Command.NONE)
    sample = sut.sample()
    # J omega_dot = r Fz mu - T_b, with omega_dot = -(1 - slip) g mu / r at a slip that barely changes
    balance = (
        CORNER.radius * CORNER.vertical_load + CORNER.inertia * (1.0 - sample.slip[0]) * CORNER.gravity / CORNER.radius
    )
    assert sample.friction[0] * balance == pytest.approx(torque, rel=2e-3)


def test_wheel_momentum_and_vehicle_momentum_account_for_the_brake() -> None:
    # (2.15): J d omega + r m dv = -T_b dt, whatever the friction does
    sut = plant(count=1, actuator=ActuatorParameters(delay=0.0, apply_rate=4000.0, release_rate=4000.0))
    before = sut.sample()
    impulse = 0.0
    for k in range(80):
        begin = sut.sample().brake_torque[0]
        sut.advance(900.0 / GAIN, Command.DECREASE if 40 <= k < 55 else Command.NONE)
        impulse += 0.5 * (begin + sut.sample().brake_torque[0]) * SAMPLE_TIME
    after = sut.sample()
    assert after.wheel_speed[0] > 0.0
    change = CORNER.inertia * (after.wheel_speed[0] - before.wheel_speed[0])
    change += CORNER.radius * CORNER.mass * (after.speed - before.speed)
    assert change == pytest.approx(-impulse, rel=1e-6)


def test_reported_rates_are_the_derivatives_of_the_reported_states() -> None:
    sut = plant(actuator=ActuatorParameters(delay=0.0, apply_rate=2000.0, release_rate=2000.0))
    samples = []
    for _ in range(70):
        samples.append(sut.sample())
        sut.advance(1500.0 / GAIN, Command.NONE)
    torque_rate = 2000.0
    for before, now, after in zip(samples[10:60], samples[11:61], samples[12:62], strict=True):
        slip_rate = (after.slip[0] - before.slip[0]) / (2.0 * SAMPLE_TIME)
        assert now.slip_rate[0] == pytest.approx(slip_rate, rel=0.02, abs=1e-3)
        acceleration = (after.speed - before.speed) / (2.0 * SAMPLE_TIME)
        assert now.acceleration == pytest.approx(acceleration, rel=2e-2, abs=1e-2)
        jerk = (after.wheel_speed[0] - 2.0 * now.wheel_speed[0] + before.wheel_speed[0]) / SAMPLE_TIME**2
        # (8.3): H is the wheel's jerk plus the torque's rate over J
        assert now.h[0] == pytest.approx(jerk + torque_rate / CORNER.inertia, rel=0.03, abs=40.0)


def test_the_plant_stops_and_stays_stopped() -> None:
    sut = plant(speed=3.0)
    for _ in range(400):
        sut.advance(800.0 / GAIN, Command.NONE)
    sample = sut.sample()
    assert sample.speed == 0.0
    assert sample.wheel_speed[0] == 0.0
    assert np.isnan(sample.slip_rate[0])
    assert all(np.isfinite(getattr(sample, name)).all() for name in ("slip", "friction", "slope", "acceleration"))


def test_one_corner_and_equal_corners_brake_alike() -> None:
    alone, four = plant(1), plant(4)
    for _ in range(120):
        alone.advance(700.0 / GAIN, Command.NONE)
        four.advance(700.0 / GAIN, Command.NONE)
    assert four.sample().speed == alone.sample().speed
    np.testing.assert_array_equal(four.sample().wheel_speed, np.full(4, alone.sample().wheel_speed[0]))


def test_joined_corners_share_one_speed_and_conserve_momentum() -> None:
    sut = plant(2)
    impulse = np.zeros(2)
    before = sut.sample()
    for _ in range(60):
        begin = sut.sample().brake_torque
        sut.advance(np.array([600.0, 200.0]) / GAIN, Command.NONE)
        impulse += 0.5 * (begin + sut.sample().brake_torque) * SAMPLE_TIME
    after = sut.sample()
    assert after.wheel_speed[0] < after.wheel_speed[1]
    change = CORNER.inertia * (after.wheel_speed - before.wheel_speed).sum()
    change += 2.0 * CORNER.radius * CORNER.mass * (after.speed - before.speed)
    assert change == pytest.approx(-impulse.sum(), rel=1e-6)


def test_commands_act_after_the_delay_and_within_the_rate_limits() -> None:
    sut = plant(actuator=ActuatorParameters(delay=0.010, apply_rate=5000.0, release_rate=4000.0))
    orders = [Command.NONE] * 20 + [Command.HOLD] * 10 + [Command.DECREASE] * 10 + [Command.INCREASE] * 10
    torque = [0.0]
    for order in orders:
        sut.advance(1e4 / GAIN, order)
        torque.append(float(sut.sample().brake_torque[0]))
    change = np.diff(torque)
    np.testing.assert_allclose(change[:2], 0.0)
    np.testing.assert_allclose(change[2:22], 25.0)
    np.testing.assert_allclose(change[22:32], 0.0, atol=1e-12)
    np.testing.assert_allclose(change[32:42], -20.0)
    np.testing.assert_allclose(change[42:], 25.0)


def test_the_road_changes_at_its_distances() -> None:
    sut = plant(speed=20.0, road=Road(["dry", "wet", "snow"], [0.0, 5.0, 12.5]))
    seen: dict[int, float] = {}
    for _ in range(200):
        sample = sut.sample()
        seen.setdefault(int(sample.surface[0]), sample.distance)
        np.testing.assert_array_equal(sample.theta[0], surface(["dry", "wet", "snow"][sample.surface[0]]))
        sut.advance(0.0, Command.NONE)
    step = 20.0 * SAMPLE_TIME
    assert seen[0] == 0.0
    assert 5.0 <= seen[1] < 5.0 + step + 1e-9
    assert 12.5 <= seen[2] < 12.5 + step + 1e-9


def test_corners_that_differ_share_one_speed_and_conserve_momentum() -> None:
    wheels = tuple(
        replace(wheel, radius=radius, inertia=inertia)
        for wheel, radius, inertia in zip(
            FOUR_CORNERS.wheels, (0.3, 0.29, 0.32, 0.33), (1.0, 1.1, 1.4, 1.2), strict=True
        )
    )
    car = replace(FOUR_CORNERS, front_load_share=0.6, wheels=wheels)
    sut = plant_of(car)
    radius, inertia = np.array(car.radii), np.array([wheel.inertia for wheel in wheels])
    impulse = np.zeros(4)
    before = sut.sample()
    for _ in range(40):
        begin = sut.sample().brake_torque
        sut.advance(np.array([600.0, 500.0, 300.0, 200.0]) / GAIN, Command.NONE)
        impulse += 0.5 * (begin + sut.sample().brake_torque) * SAMPLE_TIME
    after = sut.sample()
    assert np.all(after.wheel_speed > 0.0)
    change = (inertia / radius * (after.wheel_speed - before.wheel_speed)).sum() + 900.0 * (after.speed - before.speed)
    assert change == pytest.approx(-(impulse / radius).sum(), rel=1e-6)
    np.testing.assert_allclose(after.vertical_load, 900.0 * 9.81 * np.array([0.3, 0.3, 0.2, 0.2]))
    # (2.15) of the body: the sum of the forces over the sum of the masses
    assert after.acceleration == pytest.approx(-(after.vertical_load * after.friction).sum() / 900.0)


def test_the_drag_of_the_engine_slows_the_driven_wheels_like_a_brake_that_no_pressure_shows() -> None:
    wheels = tuple(replace(wheel, driven=wheel.axle == "rear") for wheel in FOUR_CORNERS.wheels)
    still = replace(FOUR_CORNERS, wheels=wheels, drag_area=0.0, rolling_resistance=0.0)
    sut = plant_of(replace(still, engine_drag_torque=60.0))
    braked = plant_of(still)
    first = sut.sample()
    np.testing.assert_allclose(first.slip_rate, np.array([0.0, 0.0, 1.0, 1.0]) * 0.3 * 60.0 / 30.0)
    braked.advance([0.0, 0.0, 60.0 / GAIN, 60.0 / GAIN], Command.NONE)  # its torque rises within this sample
    for _ in range(60):
        sut.advance(0.0, Command.NONE)
        braked.advance([0.0, 0.0, 60.0 / GAIN, 60.0 / GAIN], Command.NONE)
    sample, by_brake = sut.sample(), braked.sample()
    np.testing.assert_array_equal(sample.brake_torque, np.zeros(4))
    np.testing.assert_array_equal(sample.pressure_torque, np.zeros(4))
    np.testing.assert_allclose(sample.slip, by_brake.slip, rtol=0.01, atol=1e-12)
    assert sample.slip[2] > 0.0
    spin = 1.0 * (sample.wheel_speed - 100.0).sum() / 0.3
    assert spin + 900.0 * (sample.speed - 30.0) == pytest.approx(-2.0 * 60.0 / 0.3 * 60 * SAMPLE_TIME, rel=1e-3)


@pytest.mark.parametrize("delay", [0.0, 0.003, 0.005, 0.0125, 0.02])
def test_the_pressure_signal_shows_the_torque_of_its_delay_earlier(delay: float) -> None:
    now = plant(2, actuator=ActuatorParameters(delay=0.0, apply_rate=2000.0, release_rate=3000.0))
    late = plant_of(
        replace(corners(2), brake_pressure_delay=delay),
        actuator=ActuatorParameters(delay=0.0, apply_rate=2000.0, release_rate=3000.0),
    )
    times, torques = [], []
    for k in range(40):
        sample, delayed = now.sample(), late.sample()
        times.append(k * SAMPLE_TIME)
        torques.append(sample.brake_torque)
        np.testing.assert_array_equal(sample.pressure_torque, sample.brake_torque)
        np.testing.assert_array_equal(delayed.brake_torque, sample.brake_torque)  # it acts without delay
        expected = [np.interp(times[-1] - delay, times, of_wheel) for of_wheel in np.array(torques).T]
        np.testing.assert_allclose(delayed.pressure_torque, expected, atol=1e-9)
        for sut in (now, late):
            sut.advance([600.0 / GAIN, 300.0 / GAIN], Command.DECREASE if 20 <= k < 30 else Command.NONE)
    assert delay == 0.0 or not np.allclose(late.sample().pressure_torque, late.sample().brake_torque)


def test_a_model_with_other_wheels_than_the_vehicle_is_refused() -> None:
    with pytest.raises(ValueError, match="the model has 1 wheels, 'chapter car' has 4"):
        Plant(JoinedCorners([CORNER], 30.0), Road(["dry"], [0.0]), IMMEDIATE, FOUR_CORNERS)
