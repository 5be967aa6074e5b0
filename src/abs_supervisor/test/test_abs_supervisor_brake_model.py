"""The model of a brake: its orders, its additional delay, and a pressure that does not follow."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from abs_supervisor.brake_model import BrakeModel
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
    model, brake = BrakeModel(STATED), BrakeActuator(1, DT, true)
    noise = np.random.default_rng(7).standard_normal(samples)
    found, torque = [], 0.0
    for sample in range(samples):
        stamp = sample * STEP
        error = np.hypot(CHAPTER_NOISE.torque_variance**0.5, deviation) * noise[sample]
        model.update(stamp, sees * torque + error, obeys=False)
        braked = sample > 100
        command = _CYCLE[sample % len(_CYCLE)] if braked else Command.NONE
        model.order(stamp, command, DEMAND * braked)
        torque = float(brake.step(DEMAND * braked, int(command))[0])
        found.append(model.late // 1_000_000)
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
    model = BrakeModel(STATED)
    model.order(0, Command.INCREASE, DEMAND)
    for stamp in (0, STEP):
        model.update(stamp, 0.0, obeys=False)
    model.update(20 * STEP, 0.0, obeys=False)
    assert model.late == 0


@given(st.lists(st.sampled_from(list(Command)), min_size=3, max_size=40), st.floats(100.0, 2000.0))
def test_orders_under_way_do_what_the_hydraulics_do(commands: list[Command], demand: float) -> None:
    model, actuator = BrakeModel(STATED), BrakeActuator(1, DT, STATED)
    torque = 0.0
    for sample, command in enumerate(commands):
        stamp = sample * STEP
        model.order(stamp, command, demand)
        torque = model.torque_at(torque, stamp, stamp + STEP)
        assert torque == pytest.approx(float(actuator.step(demand, int(command))[0]), abs=1e-9)


def pressures(
    demand: Callable[[int], float], command: Callable[[int], Command], change: Callable[[list[float]], float]
) -> list[str]:
    model, brake, random = BrakeModel(STATED), BrakeActuator(1, DT), np.random.default_rng(2)
    true, texts = [0.0] * 40, []
    for k in range(400):
        felt = change(true) + 3.2 * float(random.standard_normal())
        model.update((k + 1) * STEP, felt, obeys=True)
        texts.append(model.text)
        model.order((k + 1) * STEP, command(k), demand(k))
        true.append(float(brake.step(demand(k), command(k))[0]))
    return texts


def cycling(k: int) -> Command:
    return (
        (Command.INCREASE, Command.DECREASE, Command.HOLD, Command.INCREASE)[k // 13 % 4] if k > 120 else Command.NONE
    )


@pytest.mark.parametrize("level", [150.0, 500.0, 1200.0])
@pytest.mark.parametrize("command", [lambda k: Command.NONE, cycling])
def test_pressure_that_follows_is_not_blamed(level: float, command: Callable[[int], Command]) -> None:
    texts = pressures(lambda k: level if k >= 100 else 0.0, command, lambda true: true[-1])
    assert not any(texts)


@pytest.mark.parametrize("level", [150.0, 500.0, 1200.0])
@pytest.mark.parametrize(
    "change", [lambda true: 0.0, lambda true: 0.5 * true[-1], lambda true: true[-13]], ids=["stuck", "half", "late"]
)
def test_pressure_that_does_not_follow_is_named_within_half_a_second(
    level: float, change: Callable[[list[float]], float]
) -> None:
    texts = pressures(lambda k: level if k >= 100 else 0.0, lambda k: Command.NONE, change)
    named = next(k for k, text in enumerate(texts) if text)
    assert 0.0 < (named - 100) * DT <= 0.5


@pytest.mark.parametrize("level", [55.0, 77.0, 150.0])
def test_half_of_a_gentle_pressure_is_named_and_one_with_tolerances_is_not(level: float) -> None:
    halved = pressures(lambda k: level if k >= 100 else 0.0, lambda k: Command.NONE, lambda true: 0.5 * true[-1])
    named = next(k for k, text in enumerate(halved) if text)
    assert 0.0 < (named - 100) * DT <= 0.5
    assert "N m" in halved[named]
    for gain, offset in ((0.85, -8.0), (1.15, 8.0)):
        with_tolerances = pressures(
            lambda k: level if k >= 100 else 0.0,
            cycling,
            lambda true, gain=gain, offset=offset: gain * true[-1] + offset,  # type: ignore[misc]
        )
        assert not any(with_tolerances)


@pytest.mark.parametrize("rate", [100.0, 400.0, 2000.0])
def test_pressure_that_follows_a_pedal_that_moves_is_not_blamed(rate: float) -> None:
    def pedal(k: int) -> float:
        return min(rate * DT * k, 300.0) - min(max(rate * DT * (k - 250), 0.0), 200.0)

    assert not any(pressures(pedal, lambda k: Command.NONE, lambda true: true[-1]))
