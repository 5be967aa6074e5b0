"""Parameters of friction_curve_id: of the node, the bag runner and the parameter file."""

from dataclasses import dataclass
from math import sqrt

from friction_curve_id.banded_normal_equations import MeasurementNoise
from friction_curve_id.curve_fitting import StartParameters
from friction_curve_id.friction_samples import FrictionSource
from friction_curve_id.interface import CurveEstimator, WheelParameters
from friction_curve_id.methods import DEFAULT, METHODS, make_estimator
from friction_curve_id.sample_gate import GateParameters
from friction_curve_id.vehicle_samples import VehicleParameters
from friction_runtime.parameters import check_wheels, parameter, per_wheel

VEHICLE, TYRE_FORCE = "vehicle", "tyre_force"
SLIP, VEHICLE_VELOCITY, NO_SPEED = "slip", "vehicle_velocity", "none"


@dataclass(frozen=True)
class FrictionCurveParameters:
    """All of them, with unit and range. Tuples hold one value for all wheels, or one each."""

    wheels: tuple[str, ...] = parameter(("front_left",), "names of the wheels, as in wheel_states", read_only=True)
    method: str = parameter(
        DEFAULT,
        "how the curve is identified",
        choices=(*METHODS, VEHICLE, TYRE_FORCE),
        read_only=True,
    )
    speed_source: str = parameter(
        SLIP,
        "where the vehicle speed comes from: the topic <wheel>/slip, vehicle_velocity, or none",
        choices=(SLIP, VEHICLE_VELOCITY, NO_SPEED),
        read_only=True,
    )
    radii: tuple[float, ...] = parameter((0.3,), "effective rolling radius", unit="m", minimum=0.05, maximum=2.0)
    inertias: tuple[float, ...] = parameter((1.0,), "wheel inertia J", unit="kg m^2", minimum=1e-3, maximum=1e3)
    masses: tuple[float, ...] = parameter((225.0,), "mass a wheel decelerates", unit="kg", minimum=1.0, maximum=1e5)
    vertical_loads: tuple[float, ...] = parameter((2207.25,), "vertical load Fz", unit="N", minimum=10.0, maximum=1e6)
    brake_gains: tuple[float, ...] = parameter(
        (1e-4,), "k of T_b = k p, (1.1)", unit="N m/Pa", minimum=1e-9, maximum=1.0
    )
    wheel_speed_variance: float = parameter(
        0.005, "of the noise of a wheel speed", unit="rad^2/s^2", minimum=1e-8, maximum=100.0
    )
    speed_variance: float = parameter(
        0.25, "of the noise of the vehicle speed", unit="m^2/s^2", minimum=1e-6, maximum=100.0
    )
    torque_variance: float = parameter(
        10.0, "of the noise of the brake torque", unit="N^2 m^2", minimum=1e-4, maximum=1e6
    )
    friction_source: str = parameter(
        FrictionSource.DEAD_RECKONED.value,
        "friction samples of ml, rml, rml_ml, ls, rls",
        choices=tuple(source.value for source in FrictionSource),
    )
    lambda_init: float = parameter(
        0.0, "slip from which those methods (and tyre_force) start", minimum=0.0, maximum=0.5
    )
    initial_samples: int = parameter(20, "friction samples they start with", minimum=4, maximum=400)
    minimum_speed: float = parameter(3.0, "no estimate below this vehicle speed", unit="m/s", minimum=0.5, maximum=30.0)
    abs_activation_slip: float = parameter(0.15, "slip whose first passing is marked", minimum=0.01, maximum=0.9)
    static_loads: tuple[float, ...] = parameter(
        (1.0,), "method vehicle: load of each wheel at rest, in any unit", minimum=1e-3, maximum=1e6
    )
    transfer_shares: tuple[float, ...] = parameter(
        (0.0,), "method vehicle: change of each wheel's share per g of deceleration", minimum=-1.0, maximum=1.0
    )
    rolling_resistance: float = parameter(
        0.012, "method vehicle: rolling resistance", unit="g", minimum=0.0, maximum=0.1
    )
    drag_per_speed_squared: float = parameter(
        2.3e-4, "method vehicle: aerodynamic drag rho cd A / (2 m)", unit="1/m", minimum=0.0, maximum=0.1
    )
    relaxation_length: float = parameter(
        0.3, "method vehicle: relaxation length of the tyres", unit="m", minimum=1e-3, maximum=3.0
    )
    timing_stddev: float = parameter(
        0.01, "method vehicle: doubt about the speed reference's timing", unit="s", minimum=1e-4, maximum=0.1
    )
    imu_axis: str = parameter("x", "axis of the accelerometer along the car", choices=("x", "y", "z"))
    imu_sign: float = parameter(1.0, "1 if that axis points forward, -1 if backward", minimum=-1.0, maximum=1.0)
    imu_offset: float = parameter(0.0, "known offset, taken off", unit="m/s^2", minimum=-20.0, maximum=20.0)
    max_gap: float = parameter(
        0.025, "longer gaps in wheel_states are not bridged", unit="s", minimum=0.001, maximum=1.0
    )
    deadline: float = parameter(
        0.05, "message time a sample waits for the other inputs", unit="s", minimum=0.001, maximum=1.0
    )

    def __post_init__(self) -> None:
        """Refuse what makes no vehicle."""
        check_wheels(self.wheels)
        for name in ("radii", "inertias", "masses", "vertical_loads", "brake_gains"):
            per_wheel(name, getattr(self, name), self.wheels)
        if abs(self.imu_sign) != 1.0:
            raise ValueError(f"parameter 'imu_sign' = {self.imu_sign} must be 1 or -1")
        if self.method == VEHICLE:
            if self.speed_source == NO_SPEED:
                raise ValueError("parameter 'speed_source' = 'none' does not serve the method 'vehicle'")
            self.vehicle()

    def wheel(self, name: str) -> WheelParameters:
        """Return those of one wheel."""
        return WheelParameters(
            *(
                per_wheel(field, getattr(self, field), self.wheels)[name]
                for field in ("radii", "inertias", "masses", "vertical_loads")
            )
        )

    def brake_gain(self, name: str) -> float:
        """K of T_b = k p of one wheel [N m/Pa]."""
        return per_wheel("brake_gains", self.brake_gains, self.wheels)[name]

    def gate(self) -> GateParameters:
        """Return the limits of what enters a fit."""
        return GateParameters(min_speed=self.minimum_speed, max_gap=self.max_gap)

    def start(self) -> StartParameters:
        """Return when a fit begins."""
        return StartParameters(lambda_init=self.lambda_init, initial_samples=self.initial_samples)

    def noise(self) -> MeasurementNoise:
        """Return that of the sensors."""
        return MeasurementNoise(
            wheel_speed=sqrt(self.wheel_speed_variance),
            speed=sqrt(self.speed_variance),
            torque=sqrt(self.torque_variance),
        )

    def estimator(self, name: str) -> CurveEstimator:
        """Make the estimator of one wheel by the method, one of METHODS."""
        return make_estimator(
            self.method, self.wheel(name), self.gate(), self.noise(), FrictionSource(self.friction_source), self.start()
        )

    def vehicle(self) -> VehicleParameters:
        """Return those of the whole vehicle."""
        loads = per_wheel("static_loads", self.static_loads, self.wheels)
        transfers = per_wheel("transfer_shares", self.transfer_shares, self.wheels)
        radii = per_wheel("radii", self.radii, self.wheels)
        return VehicleParameters(
            radii=tuple(radii[wheel] for wheel in self.wheels),
            static_shares=tuple(loads[wheel] / sum(loads.values()) for wheel in self.wheels),
            transfer_shares=tuple(transfers[wheel] for wheel in self.wheels),
            rolling_resistance=self.rolling_resistance,
            drag_per_speed_squared=self.drag_per_speed_squared,
            relaxation_length=self.relaxation_length,
            timing_stddev=self.timing_stddev,
        )
