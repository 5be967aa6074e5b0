"""Parameters of wheel_slip: of the node, the bag runner and the parameter file."""

from dataclasses import dataclass

from friction_runtime.parameters import check_wheels, parameter, per_wheel
from wheel_slip.estimator import EstimatorParameters
from wheel_slip.slide_detector import SlideParameters
from wheel_slip.speed_filter import SpeedFilterParameters
from wheel_slip.vehicle_speed import VehicleSpeedParameters


@dataclass(frozen=True)
class WheelSlipParameters:
    """All of them, with unit and range."""

    wheels: tuple[str, ...] = parameter(("front_left",), "names of the wheels, as in wheel_states", read_only=True)
    radii: tuple[float, ...] = parameter(
        (0.3,), "effective rolling radius, one for all wheels or one each", unit="m", minimum=0.05, maximum=2.0
    )
    driven_wheels: tuple[str, ...] = parameter(
        (), "wheels the engine drives; empty if all are, or unknown", read_only=True
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
        0.001,
        "change of offset in the square root of a second while observed",
        unit="m/s^2",
        minimum=1e-4,
        maximum=10.0,
    )
    blind_offset_walk: float = parameter(
        0.06, "the same while the wheels slide: change of road slope", unit="m/s^2", minimum=1e-4, maximum=10.0
    )
    slide_window: float = parameter(
        0.2, "window over which wheels are compared with the accelerometer", unit="s", minimum=0.02, maximum=1.0
    )
    slide_threshold: float = parameter(
        0.15, "difference over that window above which a wheel slides", unit="m/s", minimum=0.01, maximum=5.0
    )
    slide_above: float = parameter(
        3.0, "acceleration above which wheels are not believed", unit="m/s^2", minimum=0.1, maximum=20.0
    )
    roll_below: float = parameter(
        2.5, "acceleration below which they may be believed again", unit="m/s^2", minimum=0.1, maximum=20.0
    )
    slip_per_acceleration: float = parameter(
        0.004, "uncertainty of a rolling wheel's slip per acceleration", unit="s^2/m", minimum=0.0, maximum=0.1
    )
    radius_uncertainty: float = parameter(
        0.002, "uncertainty of all radii together, as a share", minimum=0.0, maximum=0.1
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
        0.07, "no slip where its standard deviation is larger", minimum=1e-3, maximum=1.0
    )
    learn_radii: bool = parameter(False, "calibrate the radii while the car coasts, and use them")
    max_gap: float = parameter(
        0.1, "longer gaps in wheel_states or imu/data are not bridged", unit="s", minimum=0.001, maximum=1.0
    )
    deadline: float = parameter(
        0.05, "message time wheel_states waits for imu/data", unit="s", minimum=0.001, maximum=1.0
    )

    def __post_init__(self) -> None:
        """Refuse what makes no car."""
        check_wheels(self.wheels)
        per_wheel("radii", self.radii, self.wheels)
        strangers = sorted(set(self.driven_wheels) - set(self.wheels))
        if strangers:
            raise ValueError(f"parameter 'driven_wheels' names '{strangers[0]}', which is not one of 'wheels'")
        if self.roll_below > self.slide_above:
            raise ValueError(f"parameter 'roll_below' = {self.roll_below} must not exceed 'slide_above'")
        if abs(self.imu_sign) != 1.0:
            raise ValueError(f"parameter 'imu_sign' = {self.imu_sign} must be 1 or -1")

    def estimator(self) -> EstimatorParameters:
        """Return those of the algorithm."""
        radii = per_wheel("radii", self.radii, self.wheels)
        return EstimatorParameters(
            radii=tuple(radii[wheel] for wheel in self.wheels),
            driven=tuple(wheel in self.driven_wheels for wheel in self.wheels),
            vehicle_speed=VehicleSpeedParameters(
                SpeedFilterParameters(
                    self.acceleration_stddev, self.offset_stddev, self.offset_walk, self.blind_offset_walk
                ),
                SlideParameters(
                    window=self.slide_window,
                    threshold=self.slide_threshold,
                    slide_above=self.slide_above,
                    roll_below=self.roll_below,
                ),
                rim_speed_variance=(self.wheel_speed_stddev * max(radii.values())) ** 2,
                slip_per_acceleration=self.slip_per_acceleration,
                radius_uncertainty=self.radius_uncertainty,
                sensor_timeout=self.speed_timeout,
            ),
            wheel_speed_stddev=self.wheel_speed_stddev,
            wheel_jerk_density=self.wheel_jerk_density,
            minimum_speed=self.minimum_speed,
            max_gap=self.max_gap,
            max_slip_stddev=self.max_slip_stddev,
            learn_radii=self.learn_radii,
        )
