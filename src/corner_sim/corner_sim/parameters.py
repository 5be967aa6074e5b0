"""Parameters of the plant."""

from collections.abc import Mapping
from dataclasses import dataclass

from corner_sim.car_plant import CarModelParameters
from friction_parameters.generated import ShippedFile
from friction_parameters.parameter import constant, group, parameter
from vehicle_models.brake_actuator import ActuatorParameters
from vehicle_models.surfaces import SURFACES, surface
from vehicle_models.vehicle_file import vehicle_file_parameter


@dataclass(frozen=True)
class SimParameters:
    """Every parameter of the node, with unit and range. The car is in the vehicle file."""

    vehicle_file: str = vehicle_file_parameter("chapter_corner")
    model: str = parameter(
        "single_corner",
        "vehicle model: corners that share one body, or a car with load transfer, pitch and tyre relaxation",
        choices=("single_corner", "car"),
        read_only=True,
    )
    initial_speed: float = parameter(30.0, "speed at the start, rolling freely", unit="m/s", minimum=0.0, maximum=150.0)

    surfaces: tuple[str, ...] = parameter(
        ("dry",), f"surfaces of the road in order: {', '.join(SURFACES)}, or theta as '1.28,24,0.52'"
    )
    surface_distances: tuple[float, ...] = parameter((0.0,), "distance at which each begins", unit="m", minimum=0.0)

    demand_source: str = parameter(
        "profile",
        "source of the driver's demand: the profile below, or the topic brake_demand",
        choices=("profile", "topic"),
        read_only=True,
    )
    demand_unit: str = parameter(
        "peak_ratio",
        "unit of demand_level: multiples of the first wheel's peak torque on the first surface, or N m at that wheel",
        choices=("peak_ratio", "torque"),
    )
    demand_level: float = parameter(1.5, "brake torque the driver demands, in demand_unit", minimum=0.0, maximum=1e5)
    demand_start: float = parameter(
        0.5, "start of braking after the start of the run", unit="s", minimum=0.0, maximum=1e5
    )
    demand_rise: float = parameter(0.0, "time to the full demand, 0: a step", unit="s", minimum=0.0, maximum=1e5)
    demand_hold: float = parameter(1000.0, "time at the full demand", unit="s", minimum=0.0, maximum=1e5)
    demand_release: float = parameter(0.0, "time back to none, 0: a step", unit="s", minimum=0.0, maximum=1e5)

    car: CarModelParameters = group(CarModelParameters())
    actuator: ActuatorParameters = group(ActuatorParameters())

    noise: str = parameter("chapter", "sensor noise: of section 8.3.2, or none", choices=("chapter", "none"))
    acceleration_variance: float = parameter(
        0.0, "variance of the accelerometer noise (none in section 8.3.2)", unit="m^2/s^4", minimum=0.0, maximum=100.0
    )
    acceleration_bias: float = constant(
        0.0, "unknown constant error of the accelerometer; a known one belongs in the vehicle file", unit="m/s^2"
    )
    seed: int = parameter(0, "seed of the noise", minimum=0, maximum=2**31 - 1)

    vehicle_velocity: bool = parameter(True, "publish the speed sensor on vehicle_velocity", read_only=True)
    tyre_signals: bool = parameter(
        False, "publish <wheel>/tyre_signals: encoder voltage and in-tyre acceleration at 10 kHz", read_only=True
    )
    inflation_pressure: float = constant(2e5, "gauge pressure of the tyres (tyre_signals)", unit="Pa")
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
    exit_when_done: bool = parameter(False, "exit with code 0 when the run has ended", read_only=True)

    def __post_init__(self) -> None:
        """Refuse combinations that do not make a valid run.

        Raises:
            ValueError: parameters do not fit each other; the message names them.
        """
        for name in self.surfaces:
            try:
                surface(name)
            except ValueError as error:
                raise ValueError(f"parameter 'surfaces': {error}") from None
        if self.real_time_factor == 0.0 and not self.lock_step:
            raise ValueError("parameter 'real_time_factor' = 0 needs lock_step: nothing else would hold the plant back")


SHIPPED: Mapping[str, ShippedFile] = {
    "corner_sim": ShippedFile(
        "The plant: the single corner of section 8.3.2 under a panic stop on a dry road.\n"
        "Parameters not marked 'start only' may be set live; they take effect at the next ~/reset.",
        SimParameters(),
    ),
}
