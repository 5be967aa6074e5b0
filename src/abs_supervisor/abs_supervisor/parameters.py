"""Parameters of abs_supervisor: of the node, the bag runner and the parameter file."""

from dataclasses import dataclass

from abs_supervisor.fsm import Thresholds
from friction_runtime.parameters import check_wheels, parameter, per_wheel


@dataclass(frozen=True)
class SupervisorParameters:
    """All of them, with unit and range."""

    wheels: tuple[str, ...] = parameter(("front_left",), "names of the wheels", read_only=True)
    shadow: bool = parameter(True, "publish the state, never a command", read_only=True)
    braking_source: str = parameter(
        "demand",
        "what tells that the driver brakes: brake_demand, or <wheel>/brake_pressure with hysteresis",
        choices=("demand", "pressure"),
        read_only=True,
    )
    brake_gains: tuple[float, ...] = parameter(
        (1e-4,), "k of T_b = k p (1.1), one for all wheels or one each", unit="N m/Pa", minimum=1e-7, maximum=1.0
    )
    braking_torque: float = parameter(
        50.0, "T-bar: braking begins at this torque", unit="N m", minimum=1.0, maximum=1e4
    )
    release_torque: float = parameter(
        20.0, "source pressure: braking is over below this torque ...", unit="N m", minimum=0.0, maximum=1e4
    )
    release_hold: float = parameter(
        0.2, "... held for this long, longer than a release of ours", unit="s", minimum=0.0, maximum=5.0
    )
    h_instability: float = parameter(
        -1.0, "H_inst: stability is lost at or below", unit="rad/s^3", minimum=-1e5, maximum=-1e-3
    )
    h_stability: float = parameter(
        8000.0, "H_st: stability is regained at or above", unit="rad/s^3", minimum=1e-3, maximum=1e6
    )
    wait: float = parameter(0.035, "n: least time in S21", unit="s", minimum=0.0, maximum=1.0)
    release_timeout: float = parameter(0.165, "longest time in S22", unit="s", minimum=0.005, maximum=10.0)
    tolerance: float = parameter(
        0.02, "message time of invalid input after which the fail-safe acts", unit="s", minimum=0.0, maximum=1.0
    )
    stale_after: float = parameter(
        0.1, "silence (node's clock) after which the fail-safe acts", unit="s", minimum=0.02, maximum=5.0
    )
    demand_timeout: float = parameter(
        0.2, "a demand is held this long where no newer one comes", unit="s", minimum=0.0, maximum=5.0
    )
    deadline: float = parameter(
        0.05, "message time friction_slope waits for demand or pressure", unit="s", minimum=0.001, maximum=1.0
    )

    def __post_init__(self) -> None:
        """Refuse what makes no machine."""
        check_wheels(self.wheels)
        per_wheel("brake_gains", self.brake_gains, self.wheels)
        if not self.release_torque < self.braking_torque:
            raise ValueError(
                f"parameter 'release_torque' = {self.release_torque} must be below "
                f"'braking_torque' = {self.braking_torque}"
            )

    def thresholds(self) -> Thresholds:
        """Return those of the state machine."""
        return Thresholds(self.h_instability, self.h_stability, self.wait, self.release_timeout)

    def brake_gain(self, wheel: str) -> float:
        """K of T_b = k p [N m/Pa]."""
        return per_wheel("brake_gains", self.brake_gains, self.wheels)[wheel]
