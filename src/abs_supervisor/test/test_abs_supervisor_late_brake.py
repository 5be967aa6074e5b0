"""A brake that answers later than its hydraulics are stated to, and what is learned from its orders."""

from dataclasses import replace

import numpy as np
import pytest

from abs_supervisor.law.brake_line import BrakeLine
from abs_supervisor.law.late_brake import LateBrake
from corner_sim.sensors import CHAPTER_NOISE
from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator, Command

STATED = ActuatorParameters()
STEP, DT = 5_000_000, 0.005
DEMAND = 2000.0
_CYCLE = (Command.INCREASE,) * 8 + (Command.HOLD,) * 3 + (Command.DECREASE,) * 5 + (Command.HOLD, Command.INCREASE) * 2


def followed(true: ActuatorParameters, samples: int, sees: float = 1.0, deviation: float = 0.0) -> list[int]:
    """Brake with `true` hydraulics; return what is believed after each sample [ms].

    The pressure is seen as a share `sees` of itself, with the noise of the chapter and another of `deviation` [N m].
    """
    line = BrakeLine(STATED)
    late, brake = LateBrake(line), BrakeActuator(1, DT, true)
    noise = np.random.default_rng(7).standard_normal(samples)
    found, torque = [], 0.0
    for sample in range(samples):
        stamp = sample * STEP
        error = np.hypot(CHAPTER_NOISE.torque_variance**0.5, deviation) * noise[sample]
        late.update(stamp, sees * torque + error)
        braked = sample > 100
        command = _CYCLE[sample % len(_CYCLE)] if braked else Command.NONE
        line.order(stamp, command, DEMAND * braked)
        torque = float(brake.step(DEMAND * braked, int(command))[0])
        found.append(late.by // 1_000_000)
    return found


@pytest.mark.parametrize("later", [0.0, 0.005, 0.01, 0.02, 0.03])
def test_the_lateness_is_known_before_the_pressure_has_come_to_a_peak(later: float) -> None:
    found = followed(replace(STATED, delay=STATED.delay + later), 400)
    # The first rise tells it: 75 ms after it began the brake has 375 N m.
    assert set(found[100 + round((STATED.delay + later) / DT) + 15 :]) == {round(1e3 * later)}


@pytest.mark.parametrize("share", [0.7, 1.4])
def test_a_wrong_rate_is_no_lateness(share: float) -> None:
    other = replace(STATED, apply_rate=share * STATED.apply_rate, release_rate=share * STATED.release_rate)
    assert set(followed(other, 400)) == {0}


def test_later_than_the_law_can_serve_counts_as_the_latest() -> None:
    assert followed(replace(STATED, delay=STATED.delay + 0.04), 400)[-1] <= 30


@pytest.mark.parametrize(("sees", "deviation"), [(0.0, 0.0), (0.0, 60.0), (1.0, 60.0), (0.5, 0.0)])
def test_a_pressure_that_says_nothing_of_the_orders_teaches_nothing(sees: float, deviation: float) -> None:
    assert set(followed(STATED, 600, sees, deviation)) == {0}


def test_a_gap_in_the_samples_is_no_lateness() -> None:
    line = BrakeLine(STATED)
    late = LateBrake(line)
    line.order(0, Command.INCREASE, DEMAND)
    for stamp in (0, STEP):
        late.update(stamp, 0.0)
    late.update(20 * STEP, 0.0)
    assert late.by == 0
