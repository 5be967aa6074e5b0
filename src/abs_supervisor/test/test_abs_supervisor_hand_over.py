"""Hand-over of the brake to the driver near standstill, limited to the last road torque."""

from math import isfinite, nan

import pytest

from abs_supervisor.envelope import Envelope
from abs_supervisor.release_evidence import Wheel
from abs_supervisor.tuning import EnvelopeTuning
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.vehicle import CornerParameters

STEP = 5_000_000
RADIUS = 0.3
CORNER = CornerParameters(radius=RADIUS, inertia=1.0, mass=375.0, vertical_load=3678.75)
ROAD, DEMAND = 300.0, 1000.0
"""[N m] what the road gives to a wheel that slips, and what the driver asks for."""


class Bench:
    """One wheel of which the slip was seen once, and is not known any more."""

    def __init__(self, slipped: bool = True) -> None:
        self.envelope = Envelope(CORNER, ActuatorParameters(), EnvelopeTuning())
        self.stamp = 0
        for slip, count in ((0.0, 60), (0.4, 20 if slipped else 0)):
            for _ in range(count):
                self.judge(Command.DECREASE, 4.0, ROAD, DEMAND, slip)

    def judge(self, law: Command, car: float, torque: float, demand: float = DEMAND, slip: float = nan) -> Command:
        self.stamp += STEP
        turns = car * (1.0 - (slip if isfinite(slip) else 0.1)) / RADIUS
        wheel = Wheel(turns, slip=slip, slip_stddev=0.003, car_deceleration=0.0, braked=True)
        self.envelope.look(self.stamp, wheel)
        command = self.envelope.judge(self.stamp, law, car, torque, demand)
        self.envelope.commanded(self.stamp, command, demand)
        return command


@pytest.mark.parametrize("law", [Command.HOLD, Command.DECREASE])
@pytest.mark.parametrize(
    ("car", "share", "demand", "kept"),
    [
        (1.4, 1.0, DEMAND, True),
        (0.8, 0.9, DEMAND, True),
        (1.4, 0.5, DEMAND, False),  # less than the road takes
        (1.4, 1.0, 0.9 * ROAD, False),  # the driver wants less
        (0.6, 1.0, DEMAND, False),  # it stands
    ],
)
def test_below_the_speed_of_the_abs_the_driver_gets_no_more_than_the_road_takes_until_the_car_stands(
    law: Command, car: float, share: float, demand: float, kept: bool
) -> None:
    bench = Bench()
    given = [bench.judge(law, car, share * ROAD, demand) for _ in range(5)][-1]
    assert given is (Command.HOLD if kept else Command.NONE)


def test_a_law_that_gives_the_brake_back_is_obeyed_at_once() -> None:
    bench = Bench()
    assert bench.judge(Command.NONE, 1.4, ROAD) is Command.NONE
    assert bench.judge(Command.HOLD, 1.4, ROAD) is Command.NONE


def test_a_wheel_that_never_slipped_is_the_drivers_below_the_speed_of_the_abs() -> None:
    assert Bench(slipped=False).judge(Command.HOLD, 1.4, ROAD) is Command.NONE


@pytest.mark.parametrize(("slipped", "share", "held"), [(True, 0.9, True), (True, 0.5, False), (False, 0.9, False)])
def test_a_hold_without_slip_passes_near_what_the_road_gave(slipped: bool, share: float, held: bool) -> None:
    bench = Bench(slipped)
    given = [bench.judge(Command.HOLD, 4.0, share * ROAD) for _ in range(5)][-1]
    assert given is (Command.HOLD if held else Command.INCREASE)


def test_an_order_that_was_not_given_brings_no_torque() -> None:
    """As where the other wheel of the axle allows a hold only."""
    bench = Bench()
    for _ in range(8):
        bench.judge(Command.INCREASE, 4.0, 0.6 * ROAD)
        bench.envelope.commanded(bench.stamp, Command.HOLD, DEMAND)
    assert bench.judge(Command.HOLD, 4.0, 0.75 * ROAD) is Command.INCREASE


def test_a_hold_counts_at_the_torque_that_the_orders_under_way_will_bring() -> None:
    """At 0.75 of what the road gave, with 25 N m a sample and two samples under way: 0.92 when the hold acts."""
    bench = Bench()
    for _ in range(8):
        bench.judge(Command.INCREASE, 4.0, 0.6 * ROAD)
    assert bench.judge(Command.HOLD, 4.0, 0.75 * ROAD) is Command.HOLD
