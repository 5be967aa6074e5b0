"""Parameters of friction_slope: of the node, the bag runner and the parameter files."""

from dataclasses import dataclass

from friction_runtime.parameters import check_wheels, parameter, per_wheel
from friction_slope.detector import DetectorParameters
from friction_slope.estimate import Method


@dataclass(frozen=True)
class FrictionSlopeParameters:
    """All of them, with unit and range."""

    wheels: tuple[str, ...] = parameter(("front_left",), "names of the wheels, as in wheel_states", read_only=True)
    method: str = parameter(
        "slip",
        "sign of the slip rate: measured (8.4), or that of eta (8.5)",
        choices=("slip", "no_slip"),
        read_only=True,
    )
    slip_at_crossing: bool = parameter(
        True,
        "method no_slip: wait for <wheel>/slip too, to tell the slip at a crossing (method slip always does)",
        read_only=True,
    )
    radii: tuple[float, ...] = parameter(
        (0.3,), "effective rolling radius, one for all wheels or one each", unit="m", minimum=0.05, maximum=2.0
    )
    inertias: tuple[float, ...] = parameter(
        (1.0,), "wheel inertia J, one for all wheels or one each", unit="kg m^2", minimum=0.01, maximum=100.0
    )
    vertical_loads: tuple[float, ...] = parameter(
        (2207.25,), "nominal load Fz, one for all wheels or one each", unit="N", minimum=1.0, maximum=1e5
    )
    brake_gains: tuple[float, ...] = parameter(
        (1e-4,), "k of T_b = k p (1.1), one for all wheels or one each", unit="N m/Pa", minimum=1e-7, maximum=1.0
    )
    window: int = parameter(28, "samples of the fit that gives H", minimum=3, maximum=400)
    lead: float = parameter(
        0.0, "where H is read: 0 window's centre, 1 newest sample, above 1 ahead of it", minimum=0.0, maximum=4.0
    )
    rate_window: int = parameter(28, "samples of the fits that give slip rate and eta", minimum=2, maximum=400)
    h_instability: float = parameter(
        -15.0, "indicator at or below it: stability is lost", unit="rad/s^3", minimum=-1e5, maximum=0.0
    )
    h_stability: float = parameter(
        100.0, "indicator at or above it: stability is regained", unit="rad/s^3", minimum=0.0, maximum=1e5
    )
    slip_rate_dead_zone: float = parameter(
        0.2, "slip rates up to it have no measurable sign", unit="1/s", minimum=0.0, maximum=100.0
    )
    eta_margin: float = parameter(
        0.1,
        "eta must be this much above the friction, or below 0, to have a sign (no_slip)",
        minimum=0.0,
        maximum=100.0,
    )
    minimum_torque: float = parameter(
        30.0, "brake torque below which the wheel is not braked ...", unit="N m", minimum=0.1, maximum=1e4
    )
    braking_hold: float = parameter(
        0.3, "... when it has been so for this long: a released wheel takes time", unit="s", minimum=0.0, maximum=10.0
    )
    minimum_speed: float = parameter(1.5, "no estimate below this vehicle speed", unit="m/s", minimum=0.1, maximum=20.0)
    max_deceleration: float = parameter(
        12.0,
        "no car brakes harder: bounds the reference speed that tells a locked wheel from standstill (no_slip)",
        unit="m/s^2",
        minimum=1.0,
        maximum=50.0,
    )
    max_gap: float = parameter(
        0.03, "longer gaps start the window anew and are not interpolated", unit="s", minimum=0.002, maximum=1.0
    )
    deadline: float = parameter(
        0.05, "message time wheel_states waits for the other inputs", unit="s", minimum=0.001, maximum=1.0
    )

    def __post_init__(self) -> None:
        """Refuse what makes no car or no filter."""
        check_wheels(self.wheels)
        for name in ("radii", "inertias", "vertical_loads", "brake_gains"):
            per_wheel(name, getattr(self, name), self.wheels)
        if self.lead > 0.0 and self.window < 4:
            raise ValueError(f"parameter 'window' = {self.window} must be at least 4 with a 'lead' ({self.lead})")

    @property
    def takes_slip(self) -> bool:
        """Is <wheel>/slip an input?"""
        return self.method == "slip" or self.slip_at_crossing

    def brake_gain(self, wheel: str) -> float:
        """K of T_b = k p [N m/Pa]."""
        return per_wheel("brake_gains", self.brake_gains, self.wheels)[wheel]

    def detector(self, wheel: str) -> DetectorParameters:
        """Return those of the algorithm for a wheel."""
        return DetectorParameters(
            method=Method.SLIP if self.method == "slip" else Method.NO_SLIP,
            radius=per_wheel("radii", self.radii, self.wheels)[wheel],
            inertia=per_wheel("inertias", self.inertias, self.wheels)[wheel],
            vertical_load=per_wheel("vertical_loads", self.vertical_loads, self.wheels)[wheel],
            window=self.window,
            rate_window=self.rate_window,
            lead=self.lead,
            h_instability=self.h_instability,
            h_stability=self.h_stability,
            slip_rate_dead_zone=self.slip_rate_dead_zone,
            eta_margin=self.eta_margin,
            minimum_torque=self.minimum_torque,
            braking_hold=self.braking_hold,
            minimum_speed=self.minimum_speed,
            max_deceleration=self.max_deceleration,
            max_gap=self.max_gap,
        )
