from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from corner_sim.smart_tyre.drives import dynamic_drive, quasi_static_drives, steady_drive
from vehicle_models.constants import GRAVITY
from vehicle_models.vehicle_file import load_vehicle
from vehicle_models.wheel_forces import coasting_acceleration, drag, wheel_forces

CAR = load_vehicle("smart_tyre_car")
STATIC = CAR.mass * GRAVITY / 4.0


@given(speed=st.floats(0.0, 40.0), acceleration=st.floats(-9.0, 5.0))
def test_forces_move_the_car_and_carry_its_weight(speed: float, acceleration: float) -> None:
    f = wheel_forces(CAR, speed, acceleration)
    total = 2.0 * (f.fx_front + f.fx_rear)
    assert total == pytest.approx(CAR.mass * acceleration + drag(CAR, speed), abs=1e-6)
    assert 2.0 * (f.fz_front + f.fz_rear) == pytest.approx(CAR.mass * GRAVITY)
    moment = 2.0 * CAR.wheelbase * (f.fz_rear - STATIC)
    assert moment == pytest.approx(CAR.mass * acceleration * CAR.centre_of_gravity_height, abs=1e-6)


def test_coasting_needs_neither_engine_nor_brakes() -> None:
    speed = np.linspace(5.0, 30.0, 6)
    f = wheel_forces(CAR, speed, coasting_acceleration(CAR, speed))
    np.testing.assert_allclose(f.fx_front, -CAR.rolling_resistance * f.fz_front)
    np.testing.assert_allclose(f.fx_rear, -CAR.rolling_resistance * f.fz_rear)


def test_engine_drives_the_rear_and_brakes_share() -> None:
    driving, braking = wheel_forces(CAR, 15.0, 2.5), wheel_forces(CAR, 15.0, -8.0)
    assert driving.fx_front == pytest.approx(-CAR.rolling_resistance * driving.fz_front)
    front = braking.fx_front + CAR.rolling_resistance * braking.fz_front
    rear = braking.fx_rear + CAR.rolling_resistance * braking.fz_rear
    assert front / (front + rear) == pytest.approx(0.65)


def test_smaller_wheels_brake_and_drive_harder_at_the_same_torque() -> None:
    smaller_rear = replace(
        CAR,
        wheels=tuple(replace(each, radius=0.32 if each.axle == "front" else 0.16, driven=True) for each in CAR.wheels),
    )
    driving, braking = wheel_forces(smaller_rear, 15.0, 2.5), wheel_forces(smaller_rear, 15.0, -8.0)
    for f, ratio in ((driving, 2.0), (braking, 2.0 * 0.35 / 0.65)):
        front, rear = f.fx_front + 0.012 * f.fz_front, f.fx_rear + 0.012 * f.fz_rear
        assert rear / front == pytest.approx(ratio)


def test_a_car_that_nothing_drives_cannot_hold_its_speed() -> None:
    undriven = replace(CAR, wheels=tuple(replace(each, driven=False) for each in CAR.wheels))
    with pytest.raises(ValueError, match="driven"):
        wheel_forces(undriven, 20.0, 0.0)
    assert wheel_forces(undriven, 20.0, -5.0) == wheel_forces(CAR, 20.0, -5.0)


def test_dynamic_drive_has_the_five_parts_of_figure_8_20() -> None:
    drive = dynamic_drive(road_seed=0)
    assert drive.time[-1] == pytest.approx(60.0, abs=0.01)

    def part(begin: float, end: float) -> slice:
        return slice(int(begin * 1000), int(end * 1000))

    assert np.ptp(drive.speed[part(0, 13.9)]) < 1e-9
    assert np.min(drive.acceleration[part(15, 19)]) > 2.0
    assert drive.speed[part(21, 41)].mean() == pytest.approx(22.0, abs=0.1)
    assert np.max(drive.acceleration[part(42.3, 43.6)]) < -7.0
    assert drive.speed[-1] == pytest.approx(8.0, abs=0.1)
    assert drive.speed.min() > 5.0


def test_road_varies_the_load_by_three_percent_between_1_and_12_hz_and_nothing_else() -> None:
    drive = dynamic_drive(road_seed=3)
    variation = (drive.forces.fz_front - drive.smooth.fz_front) / STATIC
    assert np.std(variation) == pytest.approx(0.03, rel=0.1)
    frequency, power = signal.welch(variation, 1000.0, nperseg=8192)
    assert power[(frequency > 1.0) & (frequency < 12.0)].sum() > 0.8 * power.sum()
    other = (drive.forces.fz_rear - drive.smooth.fz_rear) / STATIC
    assert abs(np.corrcoef(variation, other)[0, 1]) < 0.2
    np.testing.assert_array_equal(drive.forces.fx_front, drive.smooth.fx_front)
    even = dynamic_drive(road_seed=3, unevenness=0.0)
    np.testing.assert_array_equal(even.forces.fz_front, even.smooth.fz_front)


def test_quasi_static_drives_go_slowly_from_10_to_25_and_back() -> None:
    up, down = quasi_static_drives(road_seed=0)
    assert up.speed[-1] == pytest.approx(25.5, abs=0.7)
    assert np.max(np.abs(up.acceleration[up.time > 10.0])) < 0.2
    assert down.speed[0] == pytest.approx(25.0) and down.speed[-1] == pytest.approx(10.0, abs=0.01)
    assert np.max(np.abs(down.acceleration)) < 0.35
    # Speed is summed at 1 kHz: half a step of the change of acceleration, 4e-3 m/s^3 at most.
    np.testing.assert_allclose(np.gradient(down.speed, down.time)[5:-5], down.acceleration[5:-5], atol=4e-6)


def test_steady_drive_is_steady() -> None:
    drive = steady_drive(17.0, 2.0, road_seed=0)
    assert np.ptp(drive.speed) == 0.0
    np.testing.assert_array_equal(drive.forces.fz_front, np.full(2000, STATIC))
