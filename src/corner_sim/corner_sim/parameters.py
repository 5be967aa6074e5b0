"""Parameters of the plant."""

from dataclasses import dataclass

from friction_runtime.parameters import check_wheels, parameter
from vehicle_models.surfaces import SURFACES


@dataclass(frozen=True)
class SimParameters:
    """Every parameter of the node; see config/corner_sim.yaml."""

    wheels: tuple[str, ...] = parameter(("front_left",), "names of the wheels", read_only=True)
    model: str = parameter(
        "single_corner",
        "vehicle: equal corners that share one body, or a car whose load moves between its axles",
        choices=("single_corner", "two_axle"),
        read_only=True,
    )
    radius: float = parameter(0.3, "effective rolling radius", unit="m", minimum=0.05, maximum=2.0)
    inertia: float = parameter(1.0, "wheel inertia", unit="kg m^2", minimum=0.01, maximum=100.0)
    mass: float = parameter(225.0, "mass a wheel: a car has four times that", unit="kg", minimum=1.0, maximum=1e5)
    wheelbase: float = parameter(2.7, "of the car (two_axle)", unit="m", minimum=0.5, maximum=20.0)
    height: float = parameter(0.5, "of the car's centre of gravity (two_axle)", unit="m", minimum=0.0, maximum=5.0)
    front_share: float = parameter(
        0.5, "share of the weight on the front axle at rest (two_axle)", minimum=0.05, maximum=0.95
    )
    drag_area: float = parameter(
        0.65, "drag coefficient times frontal area (two_axle)", unit="m^2", minimum=0.0, maximum=20.0
    )
    rolling_resistance: float = parameter(
        0.012, "coefficient of rolling resistance (two_axle)", minimum=0.0, maximum=0.5
    )
    initial_speed: float = parameter(30.0, "speed at the start, rolling freely", unit="m/s", minimum=0.0, maximum=150.0)

    surfaces: tuple[str, ...] = parameter(("dry",), "surfaces of the road in order", choices=tuple(SURFACES))
    surface_distances: tuple[float, ...] = parameter((0.0,), "distance at which each begins", unit="m", minimum=0.0)

    demand_source: str = parameter(
        "profile",
        "who brakes: the profile below, or the topic brake_demand",
        choices=("profile", "topic"),
        read_only=True,
    )
    demand_unit: str = parameter(
        "peak_ratio",
        "unit of demand_level: multiples of the first wheel's peak torque on the first surface, or N m at that wheel",
        choices=("peak_ratio", "torque"),
    )
    demand_level: float = parameter(1.5, "brake torque the driver asks for, in demand_unit", minimum=0.0, maximum=1e5)
    demand_start: float = parameter(
        0.5, "begin of braking after the start of the run", unit="s", minimum=0.0, maximum=1e5
    )
    demand_rise: float = parameter(0.0, "time to the full demand, 0: a step", unit="s", minimum=0.0, maximum=1e5)
    demand_hold: float = parameter(1000.0, "time at the full demand", unit="s", minimum=0.0, maximum=1e5)
    demand_release: float = parameter(0.0, "time back to none, 0: a step", unit="s", minimum=0.0, maximum=1e5)

    brake_gain: tuple[float, ...] = parameter(
        (1e-4,), "k of T_b = k p, one value or one a wheel", unit="N m/Pa", minimum=1e-9, maximum=1.0
    )
    actuator_delay: float = parameter(0.01, "transport delay of the hydraulics", unit="s", minimum=0.0, maximum=1.0)
    apply_rate: float = parameter(5000.0, "fastest rise of brake torque", unit="N m/s", minimum=1.0, maximum=1e7)
    release_rate: float = parameter(5000.0, "fastest fall of brake torque", unit="N m/s", minimum=1.0, maximum=1e7)
    command_timeout: float = parameter(
        0.1, "a brake_command older than this (message time) counts as NONE", unit="s", minimum=0.005, maximum=10.0
    )

    noise: str = parameter("chapter", "sensor noise: of section 8.3.2, or none", choices=("chapter", "none"))
    acceleration_variance: float = parameter(
        0.0, "noise of the accelerometer (the chapter gives none)", unit="m^2/s^4", minimum=0.0, maximum=100.0
    )
    acceleration_offset: float = parameter(
        0.0, "constant error of the accelerometer", unit="m/s^2", minimum=-10.0, maximum=10.0
    )
    seed: int = parameter(0, "seed of the noise", minimum=0, maximum=2**31 - 1)

    vehicle_velocity: bool = parameter(True, "publish the speed sensor on vehicle_velocity", read_only=True)
    tyre_signals: bool = parameter(
        False, "publish <wheel>/tyre_signals: encoder voltage and in-tyre acceleration at 10 kHz", read_only=True
    )
    inflation_pressure: float = parameter(
        2e5, "gauge pressure of the tyres (tyre_signals)", unit="Pa", minimum=5e4, maximum=1e6
    )
    publish_clock: bool = parameter(False, "publish /clock", read_only=True)
    start_stamp: int = parameter(
        0, "stamp of the first sample, 0: the wall clock at start", unit="ns", minimum=0, maximum=2**62, read_only=True
    )
    real_time_factor: float = parameter(
        1.0, "message time over wall time; 0: as fast as the commands come (lock-step only)", minimum=0.0, maximum=50.0
    )
    lock_step: bool = parameter(
        False, "wait for each wheel's brake_command with the last stamp before each step", read_only=True
    )
    lock_step_timeout: float = parameter(
        5.0,
        "wall time after which a missing brake_command (before the start: a missing node) is an error",
        unit="s",
        minimum=0.1,
        maximum=600.0,
    )
    autostart: bool = parameter(True, "start by itself; else wait for ~/start", read_only=True)
    wait_for_subscribers: int = parameter(
        0, "subscriptions to wheel_states to wait for before the first start", minimum=0, maximum=100, read_only=True
    )
    settle_time: float = parameter(
        1.0,
        "wall time from then to the first sample, for the other nodes to find each other",
        unit="s",
        minimum=0.0,
        maximum=60.0,
        read_only=True,
    )
    end_speed: float = parameter(
        0.0, "the run ends at or below this speed; negative: never by speed", unit="m/s", minimum=-1.0, maximum=150.0
    )
    end_time: float = parameter(
        0.0, "the run ends after this message time, 0: never by time", unit="s", minimum=0.0, maximum=1e6
    )
    exit_when_done: bool = parameter(False, "leave with exit code 0 when the run has ended", read_only=True)

    def __post_init__(self) -> None:
        """Refuse combinations that make no run.

        Raises:
            ValueError: what does not fit, by name.
        """
        check_wheels(self.wheels)
        if self.model == "two_axle" and len(self.wheels) != 4:
            raise ValueError(
                "parameter 'wheels' must name the four wheels of model two_axle, in the order front left, front right, "
                f"rear left, rear right: {list(self.wheels)}"
            )
        if self.real_time_factor == 0.0 and not self.lock_step:
            raise ValueError("parameter 'real_time_factor' = 0 needs lock_step: nothing else would hold the plant back")
