"""Messages, ages and reasons in the monitor and the live view."""

from __future__ import annotations

from math import nan

import pytest
from friction_msgs.msg import (
    BrakeCommand,
    FrictionCurve,
    FrictionSlope,
    SupervisorState,
    TyreForce,
    Validity,
    WheelSlip,
)
from rich.console import Console

from friction_bringup.live_view import WheelView, wheels_view


def shown(view: WheelView, now: float, width: int = 160) -> str:
    """Return the monitor's table as plain text."""
    console = Console(width=width, color_system=None)
    with console.capture() as capture:
        console.print(wheels_view({"rear_left": view}, now, width, "title"))
    return capture.get()


@pytest.fixture
def view() -> WheelView:
    """Make a wheel with a message on every topic at t = 10 s."""
    messages = {
        "slip": WheelSlip(slip=0.1234, vehicle_speed=21.5, validity=Validity(valid=True)),
        "friction_slope": FrictionSlope(sign=-1, validity=Validity(valid=True)),
        "friction_curve": FrictionCurve(
            lambda_max=0.17, lambda_max_stddev=0.02, mu_max=1.17, mu_max_stddev=0.03, validity=Validity(valid=True)
        ),
        "abs_supervisor": SupervisorState(state=SupervisorState.S21, validity=Validity(valid=True)),
        "brake_command": BrakeCommand(command=BrakeCommand.DECREASE),
        "tyre_force": TyreForce(fx=-2500.0, fz=4000.0, fx_stddev=nan, validity=Validity(valid=True)),
    }
    return WheelView(messages=messages, arrivals=dict.fromkeys(messages, 10.0))


def test_every_estimate_is_shown_with_its_95_percent_interval(view: WheelView) -> None:
    text = shown(view, 10.1)
    for part in ("rear_left", "0.123", "−", "S21", "decrease", "0.170±0.039", "1.17±0.06", "-2.50±–", "0.1 s"):
        assert part in text
    assert "silent for" not in text


@pytest.mark.parametrize("width", [80, 100, 160])
def test_no_number_is_cut_on_a_terminal_of_any_width(view: WheelView, width: int) -> None:
    text = shown(view, 10.1, width)
    for part in ("rear_left", "0.123", "−", "S21 wait", "decrease", "0.170", "1.17", "-2.50", "4.00", "0.1 s"):
        assert part in text
    assert "…" not in text
    assert max(map(len, text.splitlines())) <= width


def test_reason_has_a_line_of_its_own(view: WheelView) -> None:
    view.messages["slip"] = WheelSlip(validity=Validity(valid=False, text="rear_left: too slow"))
    assert "rear_left: too slow" in [line.strip() for line in shown(view, 10.1, 80).splitlines()]


def test_reason_does_not_repeat_the_name_of_the_wheel_where_it_names_a_topic(view: WheelView) -> None:
    view.messages["abs_supervisor"] = SupervisorState(
        validity=Validity(valid=False, text="rear_left/slope_vote: filling the window")
    )
    assert "rear_left: slope_vote: filling the window" in shown(view, now=10.0)


def test_forces_have_columns_only_where_there_are_any(view: WheelView) -> None:
    del view.messages["tyre_force"]
    assert "Fz" not in shown(view, 10.1)


@pytest.mark.parametrize(
    ("state", "text"),
    [
        (SupervisorState(), "–"),
        (SupervisorState(release=SupervisorState.RELEASE_BY_SLIP), "slip"),
        (SupervisorState(release=SupervisorState.RELEASE_BY_ROAD_TORQUE), "torque"),
        (SupervisorState(release=SupervisorState.RELEASE_REFUSED), "refused"),
        (
            SupervisorState(release=SupervisorState.RELEASE_BY_SLIP, limit=SupervisorState.LIMIT_NO_SPIN_UP),
            "no spin-up",
        ),
        (SupervisorState(release=SupervisorState.RELEASE_REFUSED, limit=SupervisorState.LIMIT_BUDGET), "budget"),
        (SupervisorState(limit=SupervisorState.LIMIT_RETURN), "return"),
        (SupervisorState(limit=SupervisorState.LIMIT_LOW_SPEED), "driver"),
    ],
)
def test_the_limit_in_force_is_shown_before_the_verdict_on_a_release(state: SupervisorState, text: str) -> None:
    assert WheelView({"abs_supervisor": state}).release.plain == text


def test_refused_releases_are_counted(view: WheelView) -> None:
    view.messages["abs_supervisor"].refused_releases = 4711
    assert "4711" in shown(view, 10.1)


def test_topic_that_falls_silent_is_named_with_its_age(view: WheelView) -> None:
    view.arrivals["friction_slope"] = 8.0
    text = shown(view, 10.1)
    assert "friction_slope silent for 2.1 s" in text
    assert "slip silent" not in text


def test_invalid_estimate_is_no_number_but_a_reason(view: WheelView) -> None:
    view.messages["slip"] = WheelSlip(slip=0.5, vehicle_speed=0.3, validity=Validity(valid=False, text="too slow"))
    text = shown(view, 10.1)
    assert "0.500" not in text
    assert "too slow" in text


def test_graph_without_wheels_says_what_is_waited_for() -> None:
    console = Console(width=120)
    with console.capture() as capture:
        console.print(wheels_view({}, 0.0, 120, "title"))
    assert "no wheel yet" in capture.get()
