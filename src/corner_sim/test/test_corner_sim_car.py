"""The plant of a whole car: closed forms and conservation, and that it shares nothing with what it judges."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from corner_sim.car.car import STEP, Car, Pitch, load_variation
from corner_sim.car.car_parameters import PITCH_GAIN, CarParameters, SensorParameters
from corner_sim.car.driving import Cycling, OrdinaryDriver, PressureProfile, SlipCycle, Surroundings, peak_pressures
from corner_sim.car.measured_car import Brake, Encoder, LateSignal, MeasuredCar
from corner_sim.car.random_car import random_car
from corner_sim.car.recording import END_SPEED, Recording, record
from corner_sim.car.tyres import BRUSH_TYRES, TYRES, Burckhardt, Pacejka, Scaled, Tyre
from vehicle_models.constants import AIR_DENSITY, GRAVITY

SMOOTH = CarParameters(drag_area=0.0, rolling_resistance=0.0)
QUIET = SensorParameters(wheel_speed_variance=0.0, pressure_stddev=(0.0,) * 4, acceleration_stddev=0.0)
ONLY_NUMPY = """
import sys
from importlib import import_module
from importlib.abc import MetaPathFinder

class Only(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        root = name.partition(".")[0]
        if root in sys.stdlib_module_names or root == "numpy":
            return None
        if name == "corner_sim" or f"{name}.".startswith("corner_sim.car."):
            return None
        if name in ("vehicle_models", "vehicle_models.constants"):
            return None
        raise ModuleNotFoundError(f"{name} is not numpy")

sys.meta_path.insert(0, Only())
for name in sys.argv[1:]:
    import_module(name)
"""


def cycled(parameters: CarParameters, seed: int = 0, **cycling: float) -> Recording:
    return record(parameters, SlipCycle(parameters, Cycling(**cycling)), seed)


def test_the_car_imports_nothing_but_numpy_constants_and_itself() -> None:
    directory = Path(__file__).resolve().parents[1] / "corner_sim" / "car"
    names = [f"corner_sim.car.{file.stem}" for file in directory.glob("*.py") if file.stem != "__init__"]
    assert len(names) >= 7
    done = subprocess.run([sys.executable, "-c", ONLY_NUMPY, *names], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


ALL_TYRES: dict[str, dict[str, Tyre]] = {
    **TYRES,
    "brush": BRUSH_TYRES,
    "other": {name: Scaled(t, 1.06, 1.1) for name, t in BRUSH_TYRES.items()},
}


@pytest.mark.parametrize("family", ALL_TYRES)
@pytest.mark.parametrize("road", TYRES["burckhardt"])
def test_a_tyre_is_highest_at_its_peak_and_its_slope_is_the_derivative(family: str, road: str) -> None:
    tyre = ALL_TYRES[family][road]
    lambda_max, mu_max = tyre.peak
    slips = np.linspace(0.0, 1.0, 20001)
    friction = np.array([tyre.friction(slip)[0] for slip in slips])
    assert slips[friction.argmax()] == pytest.approx(lambda_max, abs=1e-4)
    assert friction.max() == pytest.approx(mu_max, abs=1e-7)
    slopes = np.array([tyre.friction(slip)[1] for slip in slips])
    smooth = np.abs(np.diff(slopes, prepend=slopes[0], append=slopes[-1])) < 0.1  # a brush tyre has a kink at its peak
    near = smooth[1:] & smooth[:-1]
    assert near[1:-1].mean() > 0.999
    assert_allclose(np.gradient(friction, slips)[1:-1][near[1:-1]], slopes[1:-1][near[1:-1]], rtol=1e-3, atol=1e-3)
    assert tyre.friction(-0.03)[0] == -tyre.friction(0.03)[0]
    assert tyre.friction(-0.03)[1] == tyre.friction(0.03)[1]


def test_published_peaks() -> None:
    assert_allclose(TYRES["burckhardt"]["dry"].peak, (0.170, 1.170), atol=5e-4)
    assert_allclose(TYRES["burckhardt"]["snow"].peak, (0.060, 0.190), atol=5e-4)
    assert_allclose(TYRES["pacejka"]["cobblestone"].peak, TYRES["burckhardt"]["cobblestone"].peak, rtol=0.01)
    # without curvature E the magic formula has its peak at B s = tan(pi / (2 C))
    assert Pacejka(8.0, 1.6, 0.9, 0.0).peak[0] == pytest.approx(np.tan(np.pi / 3.2) / 8.0)
    assert Burckhardt(1.0, 10.0, 0.1).peak[0] == pytest.approx(np.log(100.0) / 10.0)


def test_momentum_changes_by_the_forces_and_nothing_else() -> None:
    parameters = replace(CarParameters(), slope=0.03, load_variation=0.05, relaxation_length=(0.2,) * 4)
    p, measured = parameters, MeasuredCar(parameters, 25.0, 1)
    car, cycle = measured.car, SlipCycle(parameters, Cycling(start=0.0))
    impulse, spin, wheel_start = 0.0, 0.0, sum(car.wheel_speed)

    def forces() -> tuple[float, float]:
        tyres = sum(mu * load for mu, load in zip(car.friction, car.vertical_load, strict=True))
        rolling = p.rolling_resistance * sum(car.vertical_load)
        return tyres, tyres + rolling + 0.5 * AIR_DENSITY * p.drag_area * car.speed**2 + p.mass * GRAVITY * p.slope

    tyres, total = forces()
    while car.speed > 10.0:
        pressure = cycle.pressure(measured.time, STEP, car)
        measured.step(pressure)
        before, (tyres, total) = (tyres, total), forces()
        impulse -= STEP * 0.5 * (before[1] + total)
        torque = sum(gain * each for gain, each in zip(p.brake_gain, pressure, strict=True))
        spin += STEP * (0.15 * (before[0] + tyres) - torque)
    assert p.mass * (car.speed - 25.0) == pytest.approx(impulse, rel=2e-4)
    assert sum(car.wheel_speed) - wheel_start == pytest.approx(spin, rel=5e-3)


def test_loads_at_rest_carry_the_weight_by_the_share_of_the_axles() -> None:
    load = Car(replace(SMOOTH, front_load_share=0.6), 20.0, 0).vertical_load
    assert sum(load) == pytest.approx(1500.0 * GRAVITY)
    assert load[0] + load[1] == pytest.approx(0.6 * 1500.0 * GRAVITY)


def test_a_tyre_loses_friction_with_load_by_its_sensitivity_and_the_recording_knows() -> None:
    parameters = replace(SMOOTH, load_sensitivity=0.1)
    run = record(parameters, PressureProfile((0.5, 1.0), (0.0, 6e6)), 0, speed=30.0, duration=2.0)
    moved = run.vertical_load / run.vertical_load[0] - 1.0
    assert moved[-1, 0] > 0.15 and moved[-1, 2] < -0.15
    assert_allclose(run.mu_max, (1.0 - 0.1 * moved) * parameters.tyres[0].peak[1], rtol=1e-9)
    friction = [parameters.tyres[0].friction(slip)[0] for slip in run.tyre_slip[-1]]
    assert_allclose(run.mu[-1], (1.0 - 0.1 * moved[-1]) * np.array(friction), rtol=1e-9)


@pytest.mark.parametrize("damper_share", [0.0, 1.0])
def test_a_steady_deceleration_moves_m_a_h_over_l_to_the_front(damper_share: float) -> None:
    car = Car(replace(SMOOTH, damper_share=damper_share), 40.0, 0)
    torque = 0.25 * 0.3 * 1500.0 * 5.0
    for _ in range(3000):
        car.step([torque] * 4)
    assert car.acceleration == pytest.approx(-5.0, rel=0.04)  # the wheels' inertia takes some
    load = car.vertical_load
    moved = 0.5 * (load[0] + load[1] - load[2] - load[3])
    assert moved == pytest.approx(-1500.0 * car.acceleration * 0.5 / 2.7, rel=1e-4)
    assert sum(load) == pytest.approx(1500.0 * GRAVITY)


def test_a_left_turn_loads_the_right_wheels_and_turns_them_faster() -> None:
    car = Car(SMOOTH, 20.0, 0)
    for _ in range(2000):
        car.step([0.0] * 4, curvature=0.01)
    load = car.vertical_load
    assert load[1] > load[0] and load[3] > load[2]
    right, left = car.wheel_speed[3], car.wheel_speed[2]
    assert right / left == pytest.approx((1.0 + 0.0075) / (1.0 - 0.0075), rel=1e-4)
    assert car.wheel_speed[0] > left and max(map(abs, car.slip)) < 1e-3


def test_pitch_lags_without_the_dampers_and_leads_it_with_them() -> None:
    springs, sprung = Pitch(1.6, 0.5, 0.0), Pitch(1.6, 0.5, 1.0)
    rises = []
    for pitch in (springs, sprung):
        values = []
        for _ in range(3000):
            pitch.step(-5.0, STEP)
            values.append(pitch.load_acceleration)
        assert values[-1] == pytest.approx(-5.0, rel=1e-3)
        rises.append(float(np.sum(1.0 - np.array(values) / -5.0)) * STEP)
    # area above a step response: 2 zeta / w of the springs, none with the dampers
    assert rises[0] == pytest.approx(2.0 * 0.5 / (2.0 * np.pi * 1.6), abs=2e-3)
    assert rises[1] == pytest.approx(0.0, abs=2e-3)


def test_slip_of_the_tyre_follows_over_the_relaxation_length() -> None:
    # so little friction that no speed changes, from a slip of 0.05
    tyres = (Burckhardt(1e-6, 24.0, 4e-7),) * 4
    parameters = replace(SMOOTH, tyres=tyres, relaxation_length=(0.3,) * 4, carcass_damping=0.0)
    car = Car(parameters, 20.0, 0)
    car.wheel_speed = [20.0 * 0.95 / 0.3] * 4
    for _ in range(15):
        car.step([0.0] * 4)
    assert_allclose(car.tyre_slip, 0.05 * (1.0 - np.exp(-20.0 * 0.015 / 0.3)), rtol=1e-3)


def test_steps_are_fine_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    parameters = replace(SMOOTH, relaxation_length=(0.1,) * 4)
    profile = PressureProfile((0.0, 0.3, 3.0), (0.0, 5e6, 5e6))
    speeds = []
    for step in (1e-3, 2.5e-4):
        monkeypatch.setattr("corner_sim.car.car.STEP", step)
        car = Car(parameters, 25.0, 0)
        for k in range(round(1.5 / step)):
            car.step(
                [g * each for g, each in zip(parameters.brake_gain, profile.pressure(k * step, step, car), strict=True)]
            )
        speeds.append([car.speed, *car.wheel_speed])
    assert_allclose(speeds[0], speeds[1], rtol=1e-4)


@pytest.mark.parametrize("road", ["dry", "snow"])
@pytest.mark.parametrize("relaxation", [1e-3, 0.3])
def test_a_stop_is_stable_down_to_its_end(road: str, relaxation: float) -> None:
    tyre = TYRES["burckhardt"][road]
    parameters = replace(CarParameters(), tyres=(tyre,) * 4, relaxation_length=(relaxation,) * 4, sensors=QUIET)
    run = record(parameters, PressureProfile((0.0, 0.2), (0.0, 0.5 * min(peak_pressures(parameters)))), 0)
    assert run.speed[-1] < END_SPEED + 0.05
    assert np.abs(np.diff(run.mu[100:], axis=0)).max() < 0.01  # no ringing of the wheels at low speed


def test_a_braked_car_comes_to_rest_and_stays_there() -> None:
    car = Car(replace(SMOOTH, relaxation_length=(0.2,) * 4), 5.0, 0)
    for _ in range(2000):
        car.step([500.0] * 4)
    assert car.speed == 0.0 and car.wheel_speed == [0.0] * 4
    assert car.distance == pytest.approx(5.0**2 / (2.0 * 4.0 * 500.0 / 0.3 / 1500.0), rel=0.05)


def test_pads_fade_with_the_work_they_do() -> None:
    brake = Brake(1e-4, 0.2, 1000.0, 0.01)
    assert brake.torque(1e6, 10.0) == pytest.approx(100.0)
    assert brake.gain == pytest.approx(1e-4 * (1.0 - 0.2 * 10.0 / 1000.0))
    for _ in range(200):
        brake.torque(1e6, 10.0)
    assert brake.torque(1e6, 10.0) == pytest.approx(80.0)


def test_the_pressure_sensor_lags_by_its_time_constant() -> None:
    sensors = replace(QUIET, pressure_lag=0.02, sample_rate=1000)
    run = record(replace(SMOOTH, sensors=sensors), PressureProfile((0.0,), (1e6,)), 0, duration=0.1)
    assert_allclose(run.brake_pressure[:, 0], 1e6 * (1.0 - np.exp(-run.time / 0.02)), atol=1.0)


@pytest.mark.parametrize("delay", [0.0, 0.0005, 0.01, 0.0123])
def test_a_late_signal_is_exactly_so_late(delay: float) -> None:
    late = LateSignal(delay, 1e-3)
    for k in range(100):
        late.put(k * 1e-3)
    assert late.value() == pytest.approx(99e-3 - delay)


def test_unevenness_has_its_rms_and_its_band_and_repeats_by_seed() -> None:
    load = np.array(load_variation(0.05, 3, 1e-3)) - 1.0
    assert_allclose(np.std(load, axis=0), np.full(4, 0.05))
    power = np.abs(np.fft.rfft(load[:, 0])) ** 2
    frequency = np.fft.rfftfreq(len(load), 1e-3)
    assert power[(frequency < 0.99) | (frequency > 14.01)].sum() < 1e-9 * power.sum()
    assert max(abs(float(np.corrcoef(load[:, 0], load[:, i])[0, 1])) for i in (1, 2, 3)) < 0.2
    assert load_variation(0.05, 3, 1e-3) == load_variation(0.05, 3, 1e-3)
    assert load_variation(0.05, 3, 1e-3) != load_variation(0.05, 4, 1e-3)


@pytest.mark.parametrize("rate", [100, 200])
@pytest.mark.parametrize("speed", [9.0, 40.0, 83.0])
def test_the_encoder_is_exact_at_constant_speed(rate: int, speed: float) -> None:
    encoder = Encoder(48, speed, 0.05)
    interval = 1.0 / rate
    for k in range(50):
        for part in range(5):
            encoder.turn((k + part / 5) * interval, interval / 5, speed, speed)
        # timer of 1 microsecond at both ends of the interval between the edges
        assert encoder.publish((k + 1) * interval) == pytest.approx(speed, rel=3e-6 * rate)


def test_a_ring_without_two_teeth_gives_a_speed_that_is_too_low_once_in_a_revolution() -> None:
    speed, interval = 60.0, 0.005
    encoder = Encoder(60, speed, 0.0, missing=2)
    published = []
    for k in range(400):
        encoder.turn(k * interval, interval, speed, speed)
        published.append(encoder.publish((k + 1) * interval))
    low = np.array(published) < 0.9 * speed
    assert np.array(published)[~low] == pytest.approx(speed, rel=1e-3)
    # n edges where n + 2 pitches have passed, n = 1 to 3
    assert np.all(np.array(published)[low] > 0.32 * speed) and np.all(np.array(published)[low] < 0.61 * speed)
    assert np.sum(low) == pytest.approx(400 * interval * speed / (2.0 * np.pi), abs=1.0)


def test_the_encoder_gives_the_mean_between_edges_and_never_more_than_a_tooth_allows() -> None:
    encoder, angle, time = Encoder(48, 80.0, 0.0), 0.0, 0.0
    published = []
    for k in range(200):
        omega = 80.0 - 100.0 * k * 1e-3
        encoder.turn(k * 1e-3, 1e-3, omega, omega - 0.1)
        angle, time = angle + 1e-3 * (omega - 0.05), (k + 1) * 1e-3
        if (k + 1) % 10 == 0:
            published.append(encoder.publish(time))
    # the mean over an interval of 10 ms that ends up to a tooth (2 ms) before the stamp is old by 4.5 to 8 ms
    age = (np.array(published[2:]) - (80.0 - 100.0 * np.arange(0.03, 0.2001, 0.01))) / 100.0
    assert age.min() > 0.0035 and age.max() < 0.0085
    assert encoder.publish(time + 1.0) < 2.0 * np.pi / 48 / 0.99


def test_the_accelerometer_feels_slope_pitch_scale_and_offset() -> None:
    sensors = replace(QUIET, acceleration_scale=1.02, acceleration_bias=0.3)
    parameters = replace(SMOOTH, slope=0.04, pitch_gain=PITCH_GAIN, sensors=sensors, pitch_damping=1.0)
    run = record(parameters, PressureProfile((0.0, 0.2), (0.0, 4e6)), 0, duration=2.5)
    a = run.true_acceleration[-1]
    assert run.acceleration[-1] == pytest.approx(
        0.3 + 1.02 * (a * (1.0 + GRAVITY * PITCH_GAIN) + GRAVITY * 0.04), abs=0.01
    )


def test_pressure_acceleration_and_wheel_speed_are_late_by_their_delays() -> None:
    prompt = cycled(replace(SMOOTH, sensors=QUIET))
    delays = replace(QUIET, pressure_delay=0.02, acceleration_delay=0.01, wheel_delay=0.015)
    late = cycled(replace(SMOOTH, sensors=delays))
    assert_allclose(late.brake_pressure[10:], prompt.brake_pressure[6:-4], rtol=1e-9, atol=1e-6)
    assert_allclose(late.acceleration[10:], prompt.acceleration[8:-2], rtol=1e-9)
    assert_allclose(late.wheel_speed[10:], prompt.wheel_speed[7:-3], rtol=1e-9)
    assert_array_equal(late.slip, prompt.slip)


def test_engine_drives_on_the_throttle_and_drags_without() -> None:
    parameters = replace(SMOOTH, engine_drag=50.0)
    nothing = PressureProfile((0.0,), (0.0,))
    coasting = record(parameters, nothing, 0, duration=2.0)
    throttle = Surroundings(engine_torque=200.0)
    driving = record(parameters, nothing, 0, duration=2.0, surroundings=lambda time, car: throttle)
    equivalent_mass = 1500.0 + 4.0 / 0.09
    assert coasting.speed[-1] - 25.0 == pytest.approx(-2.0 * 100.0 / 0.3 / equivalent_mass, rel=0.01)
    assert driving.speed[-1] - 25.0 == pytest.approx(2.0 * 400.0 / 0.3 / equivalent_mass, rel=0.01)


@pytest.mark.parametrize("road", TYRES["burckhardt"])
@pytest.mark.parametrize("family", TYRES)
@pytest.mark.parametrize("ramp", [0.1, 2.0])
def test_slips_are_cycled_through_the_peak(road: str, family: str, ramp: float) -> None:
    parameters = replace(CarParameters(), tyres=(TYRES[family][road],) * 4, relaxation_length=(0.2,) * 4)
    run = record(parameters, SlipCycle(parameters, Cycling(ramp=ramp)), 0, duration=4.5)
    beyond = run.tyre_slip > run.lambda_max
    crossings = (np.diff(beyond.astype(int), axis=0) == 1).sum(axis=0)
    assert crossings.min() >= 2
    assert beyond[run.time < 0.7].sum() == 0
    fast = run.speed > 10.0
    assert (run.tyre_slip[fast] / run.lambda_max).max() < 4.5


def test_the_same_seed_gives_the_same_recording_and_another_one_does_not() -> None:
    car = random_car(5, "wet", "pacejka")
    runs = [record(car.parameters, SlipCycle(car.parameters, car.cycling), seed, duration=2.0) for seed in (5, 5, 6)]
    assert_array_equal(runs[0].wheel_speed, runs[1].wheel_speed)
    assert_array_equal(runs[0].acceleration, runs[1].acceleration)
    assert (runs[0].brake_pressure != runs[2].brake_pressure).any()


def test_random_cars_fill_the_ranges_they_state() -> None:
    cars = [random_car(seed, "dry", "burckhardt").parameters for seed in range(300)]
    for values, low, high in (
        ([car.mass for car in cars], 1275.0, 1725.0),
        ([car.brake_gain[0] for car in cars], 1.17e-4, 1.43e-4),
        ([car.brake_gain[2] for car in cars], 0.63e-4, 0.77e-4),
        ([car.relaxation_length[0] for car in cars], 0.05, 0.4),
        ([car.sensors.pressure_delay for car in cars], 0.0, 0.02),
        ([car.load_variation for car in cars], 0.0, 0.06),
        ([car.engine_drag for car in cars], 0.0, 80.0),
        ([car.slope for car in cars], -0.04, 0.04),
    ):
        assert low <= min(values) < low + 0.05 * (high - low)
        assert high - 0.05 * (high - low) < max(values) <= high
    assert {car.sensors.sample_rate for car in cars} == {100, 200}
    front, rear = ([car.brake_gain[i] for car in cars] for i in (0, 2))
    assert abs(float(np.corrcoef(front, rear)[0, 1])) < 0.2


@pytest.mark.parametrize("road", ["dry", "snow"])
def test_an_ordinary_driver_uses_a_part_of_the_friction_and_all_of_the_drive(road: str) -> None:
    car = replace(random_car(2, road, "burckhardt").parameters, load_variation=0.0, slope=0.0)
    driver = OrdinaryDriver(car, 2)
    drive = record(car, driver, 2, speed=15.0, duration=80.0, surroundings=driver.surroundings)
    assert drive.speed.min() > 4.0 and drive.speed.max() < 35.0
    assert (drive.tyre_slip / drive.lambda_max).max() < 0.5
    assert drive.true_acceleration.max() > 0.4  # it accelerates
    assert drive.true_acceleration.min() < (-2.0 if road == "dry" else -0.6)  # and brakes
    assert np.abs(drive.wheel_speed[:, 0] / drive.wheel_speed[:, 1] - 1.0).max() > 0.003  # and turns


def test_a_sample_rate_that_is_no_whole_number_of_steps_is_refused() -> None:
    with pytest.raises(ValueError, match="sample_rate = 300 Hz must divide 1000 Hz"):
        MeasuredCar(replace(SMOOTH, sensors=SensorParameters(sample_rate=300)), 25.0, 0)


def test_slips_are_cycled_through_the_peak_of_the_road_on_which_a_wheel_has_come() -> None:
    dry, snow = TYRES["burckhardt"]["dry"], TYRES["burckhardt"]["snow"]
    parameters = replace(CarParameters(), tyres=(dry,) * 4)

    def change(time: float, car: Car) -> Surroundings:
        if time > 1.5:
            car.tyres = [snow] * 4
        return Surroundings()

    run = record(parameters, SlipCycle(parameters, Cycling()), 0, duration=3.5, surroundings=change)
    after = run.time > 2.0
    peak = peak_pressures(replace(parameters, tyres=(snow,) * 4))
    assert (run.brake_pressure[after].max(axis=0) < 2.0 * np.array(peak)).all()
    ratio = run.tyre_slip[after] / snow.peak[0]
    assert (ratio.max(axis=0) > 1.2).all() and (ratio.min(axis=0) < 0.8).all()
