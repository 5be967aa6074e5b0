"""Sensor noise: its moments, its whiteness and its seeds."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from corner_sim.corner import JoinedCorners
from corner_sim.plant import Plant, PlantSample
from corner_sim.road import Road
from corner_sim.sensors import CHAPTER_NOISE, NO_NOISE, Measurement, SensorNoise, Sensors
from vehicle_models.brake_actuator import ActuatorParameters
from vehicle_models.vehicle import Accelerometer
from vehicle_models.vehicle_file import load_vehicle

GAIN = np.array([1e-4, 2e-4])
FRONT = load_vehicle("chapter_car").wheels[:2]
CAR = replace(
    load_vehicle("chapter_car"),
    front_load_share=1.0,
    wheels=tuple(replace(wheel, brake_gain=float(gain)) for wheel, gain in zip(FRONT, GAIN, strict=True)),
)
COUNT = 40_000


def still_sample() -> PlantSample:
    model = JoinedCorners([CAR.corner(name) for name in CAR.wheel_names], 30.0)
    return Plant(model, Road(["dry"], [0.0]), ActuatorParameters(), CAR).sample()


def errors(sensors: Sensors, count: int) -> dict[str, np.ndarray]:
    """Errors of wheel speed, torque, speed and acceleration, each (count, channels)."""
    sample = still_sample()
    measured: list[Measurement] = [sensors.measure(sample) for _ in range(count)]
    return {
        "wheel_speed": np.array([m.wheel_speed - sample.wheel_speed for m in measured]),
        "torque": np.array([m.brake_pressure * GAIN - sample.brake_torque for m in measured]),
        "speed": np.array([[m.speed - sample.speed] for m in measured]),
        "acceleration": np.array([[m.acceleration - sample.acceleration] for m in measured]),
    }


def test_noise_is_white_with_the_variances_of_the_chapter() -> None:
    found = errors(Sensors(CHAPTER_NOISE, 0.04, 0.1, CAR, seed=7), COUNT)
    wanted = {"wheel_speed": (0.0, 0.005), "torque": (0.0, 10.0), "speed": (0.0, 0.25), "acceleration": (0.1, 0.04)}
    channels = []
    for name, (mean, variance) in wanted.items():
        for channel in found[name].T:
            # five standard errors of the mean, the variance and the correlation of COUNT independent samples
            assert abs(channel.mean() - mean) < 5.0 * np.sqrt(variance / COUNT), name
            assert abs(channel.var() / variance - 1.0) < 5.0 * np.sqrt(2.0 / COUNT), name
            centred = (channel - channel.mean()) / channel.std()
            assert abs((centred[1:] * centred[:-1]).mean()) < 5.0 / np.sqrt(COUNT), name
            channels.append(centred)
    correlation = np.array(channels) @ np.array(channels).T / COUNT - np.eye(len(channels))
    assert np.abs(correlation).max() < 5.0 / np.sqrt(COUNT)


def test_without_noise_the_sensors_tell_the_truth() -> None:
    sample = still_sample()
    measured = Sensors(NO_NOISE, 0.0, 0.0, CAR, seed=1).measure(sample)
    np.testing.assert_array_equal(measured.wheel_speed, sample.wheel_speed)
    np.testing.assert_array_equal(measured.brake_pressure, sample.brake_torque / GAIN)
    assert (measured.speed, measured.acceleration) == (sample.speed, sample.acceleration)


def test_the_same_seed_gives_the_same_noise_and_another_seed_another() -> None:
    first, again, other = (errors(Sensors(CHAPTER_NOISE, 0.04, 0.0, CAR, seed), 50) for seed in (3, 3, 4))
    for name in first:
        np.testing.assert_array_equal(first[name], again[name])
        assert not np.any(first[name] == other[name])


def test_silencing_one_kind_of_sensor_does_not_change_the_noise_of_the_others() -> None:
    silent = SensorNoise(wheel_speed_variance=0.0, speed_variance=0.0, torque_variance=10.0)
    first = errors(Sensors(CHAPTER_NOISE, 0.0, 0.0, CAR, 3), 50)
    second = errors(Sensors(silent, 0.0, 0.0, CAR, 3), 50)
    np.testing.assert_array_equal(first["torque"], second["torque"])


@pytest.mark.parametrize(
    "mounting",
    [
        Accelerometer(),
        Accelerometer(axis="y", sign=-1.0),
        Accelerometer(axis="z", bias=0.4, scale=1.03, pitch_gain=0.004),
        Accelerometer(sign=-1.0, bias=-0.2, scale=0.97, pitch_gain=0.01),
    ],
)
def test_the_accelerometer_reads_what_its_mounting_makes_of_the_acceleration(mounting: Accelerometer) -> None:
    sample = replace(still_sample(), acceleration=-7.3)
    car = replace(CAR, accelerometer=mounting)
    known = Sensors(NO_NOISE, 0.0, 0.0, car, seed=1).measure(sample).acceleration
    assert mounting.forward(SimpleNamespace(**{mounting.axis: known})) == pytest.approx(-7.3, rel=1e-12)
    off = Sensors(NO_NOISE, 0.0, 0.25, car, seed=1).measure(sample).acceleration
    assert off - known == pytest.approx(0.25)  # the unknown error comes on top, as it is


def test_a_pressure_that_is_late_shows_what_the_plant_says_of_it() -> None:
    sample = replace(still_sample(), brake_torque=np.array([500.0, 500.0]), pressure_torque=np.array([300.0, 200.0]))
    measured = Sensors(NO_NOISE, 0.0, 0.0, CAR, seed=1).measure(sample)
    np.testing.assert_allclose(measured.brake_pressure, [3e6, 1e6])
