"""Parameters of wheel_slip: of the node, the bag runner and the parameter file."""

from dataclasses import dataclass

from friction_runtime.parameters import parameter, per_wheel
from wheel_slip.estimator import EstimatorParameters
from wheel_slip.speed_filter import SpeedFilterParameters


@dataclass(frozen=True)
class WheelSlipParameters:
    """All of them, with unit and range."""

    wheels: tuple[str, ...] = parameter(("front_left",), "names of the wheels, as in wheel_states", read_only=True)
    radii: tuple[float, ...] = parameter(
        (0.3,), "effective rolling radius, one for all wheels or one each", unit="m", minimum=0.05, maximum=2.0
    )
    wheel_speed_stddev: float = parameter(0.07, "noise of a wheel speed", unit="rad/s", minimum=1e-4, maximum=10.0)
    wheel_jerk_density: float = parameter(
        3e3,
        "how fast wheels change their acceleration (bandwidth of the filter)",
        unit="rad^2/s^5",
        minimum=1.0,
        maximum=1e9,
    )
    use_imu: bool = parameter(True, "take imu/data and wait for it", read_only=True)
    imu_axis: str = parameter("x", "axis of the accelerometer along the car", choices=("x", "y", "z"))
    imu_sign: float = parameter(1.0, "1 if that axis points forward, -1 if backward", minimum=-1.0, maximum=1.0)
    imu_offset: float = parameter(
        0.0, "known offset of the accelerometer, taken off", unit="m/s^2", minimum=-20.0, maximum=20.0
    )
    acceleration_stddev: float = parameter(
        0.1, "noise of an accelerometer sample", unit="m/s^2", minimum=1e-3, maximum=10.0
    )
    offset_stddev: float = parameter(
        0.4, "offset (bias and road slope) to expect before it is learned", unit="m/s^2", minimum=1e-3, maximum=10.0
    )
    offset_walk: float = parameter(
        0.03, "change of offset in the square root of a second", unit="m/s^2", minimum=1e-4, maximum=10.0
    )
    speed_stddev: float = parameter(
        0.5, "noise of vehicle_velocity where the message gives no covariance", unit="m/s", minimum=1e-3, maximum=50.0
    )
    speed_latency: float = parameter(
        0.0, "age of the speed at the stamp of vehicle_velocity", unit="s", minimum=0.0, maximum=0.5
    )
    speed_wait: float = parameter(
        0.02,
        "a sample of vehicle_velocity is used this long after its stamp; no output waits for it",
        unit="s",
        minimum=0.0,
        maximum=0.5,
    )
    speed_timeout: float = parameter(
        0.5, "silence of vehicle_velocity after which the wheels take over", unit="s", minimum=0.01, maximum=10.0
    )
    minimum_speed: float = parameter(1.0, "no slip below this vehicle speed", unit="m/s", minimum=0.1, maximum=20.0)
    max_slip_stddev: float = parameter(
        0.05, "no slip where its standard deviation is larger", minimum=1e-3, maximum=1.0
    )
    max_gap: float = parameter(
        0.1, "longer gaps in wheel_states or imu/data are not bridged", unit="s", minimum=0.001, maximum=1.0
    )
    deadline: float = parameter(
        0.05, "message time wheel_states waits for imu/data", unit="s", minimum=0.001, maximum=1.0
    )

    def __post_init__(self) -> None:
        """Refuse what makes no car."""
        if not self.wheels or len(set(self.wheels)) != len(self.wheels) or "" in self.wheels:
            raise ValueError(f"parameter 'wheels' = {list(self.wheels)} must name at least one wheel, each once")
        per_wheel("radii", self.radii, self.wheels)
        if abs(self.imu_sign) != 1.0:
            raise ValueError(f"parameter 'imu_sign' = {self.imu_sign} must be 1 or -1")

    def estimator(self) -> EstimatorParameters:
        """Return those of the algorithm."""
        radii = per_wheel("radii", self.radii, self.wheels)
        return EstimatorParameters(
            radii=tuple(radii[wheel] for wheel in self.wheels),
            speed_filter=SpeedFilterParameters(self.acceleration_stddev, self.offset_stddev, self.offset_walk),
            wheel_speed_stddev=self.wheel_speed_stddev,
            wheel_jerk_density=self.wheel_jerk_density,
            minimum_speed=self.minimum_speed,
            max_gap=self.max_gap,
            speed_timeout=self.speed_timeout,
            max_slip_stddev=self.max_slip_stddev,
        )
