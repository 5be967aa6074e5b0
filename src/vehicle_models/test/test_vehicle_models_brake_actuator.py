"""The brake actuator: delay, rate limits and commands, by hand-worked numbers."""

import numpy as np
import pytest

from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator, Command


def test_demand_acts_after_the_delay_and_at_the_apply_rate() -> None:
    actuator = BrakeActuator(1, 0.005)
    torques = [float(actuator.step(100.0)[0]) for _ in range(8)]
    assert torques == [0.0, 0.0, 25.0, 50.0, 75.0, 100.0, 100.0, 100.0]


def test_decrease_releases_at_the_release_rate_to_zero() -> None:
    actuator = BrakeActuator(1, 0.005, ActuatorParameters(delay=0.0, apply_rate=1e6, release_rate=4000.0))
    actuator.step(50.0)
    assert [float(actuator.step(50.0, Command.DECREASE)[0]) for _ in range(4)] == [30.0, 10.0, 0.0, 0.0]


def test_hold_keeps_and_increase_returns_to_the_demand() -> None:
    actuator = BrakeActuator(1, 0.005, ActuatorParameters(delay=0.0))
    actuator.step(100.0)
    assert actuator.step(100.0, Command.HOLD)[0] == 25.0
    assert actuator.step(100.0, Command.INCREASE)[0] == 50.0


def test_command_under_way_still_acts_after_it_was_withdrawn() -> None:
    actuator = BrakeActuator(1, 0.005)
    for _ in range(10):
        actuator.step(100.0)
    actuator.step(100.0, Command.DECREASE)
    after = [float(actuator.step(100.0)[0]) for _ in range(3)]
    assert after == [100.0, 75.0, 100.0]


def test_wheels_are_independent() -> None:
    actuator = BrakeActuator(3, 0.005, ActuatorParameters(delay=0.0))
    actuator.step([100.0, 10.0, -5.0], [Command.NONE, Command.INCREASE, Command.NONE])
    np.testing.assert_array_equal(actuator.torque, [25.0, 10.0, 0.0])


def test_reset_forgets_what_is_under_way() -> None:
    actuator = BrakeActuator(1, 0.005)
    for _ in range(5):
        actuator.step(100.0)
    actuator.reset()
    assert actuator.torque[0] == 0.0
    assert actuator.step(100.0)[0] == 0.0


def test_impossible_parameters_are_refused() -> None:
    with pytest.raises(ValueError, match="rates > 0"):
        ActuatorParameters(apply_rate=0.0)
    with pytest.raises(ValueError, match="dt must be > 0"):
        BrakeActuator(1, 0.0)
