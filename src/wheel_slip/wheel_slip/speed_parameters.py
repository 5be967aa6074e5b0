"""Parameters of the vehicle speed: which source is trusted when, and how much."""

from dataclasses import dataclass

from friction_parameters.parameter import group, parameter
from wheel_slip.mode import SlideParameters
from wheel_slip.sensor_watch import SensorWatchParameters
from wheel_slip.slope_watch import SlopeParameters
from wheel_slip.speed_filter import SpeedFilterParameters
from wheel_slip.wheel_bounds import BoundParameters


@dataclass(frozen=True)
class RollingParameters:
    """How the wheels are believed while the car rolls."""

    lag: float = parameter(
        0.1,
        "a wheel sample is used this long after its stamp, where nothing has shown a slide",
        unit="s",
        minimum=0.0,
        maximum=0.5,
    )
    correlation: float = parameter(
        0.1, "time over which the slip of a rolling wheel is one error, not many", unit="s", minimum=0.001, maximum=10.0
    )
    forceless: float = parameter(
        0.3,
        "acceleration by drag and slope, for which tyres need no slip to speak of",
        unit="m/s^2",
        minimum=0.0,
        maximum=2.0,
    )
    blind_stddev: float = parameter(
        0.1, "standard deviation of the speed where encoders read zero", unit="m/s", minimum=0.001, maximum=5.0
    )
    surprise: float = parameter(
        0.6,
        "mean innovation over its deviation that noise does not reach in hours: the offset has changed",
        minimum=0.1,
        maximum=10.0,
    )
    surprise_time: float = parameter(
        0.2, "time over which that innovation is averaged", unit="s", minimum=0.01, maximum=10.0
    )
    doubt: float = parameter(
        0.05, "standard deviation of the offset after such a change", unit="m/s^2", minimum=0.0, maximum=5.0
    )


@dataclass(frozen=True)
class VehicleSpeedParameters:
    """Which source is trusted when, and how much."""

    slip_per_acceleration: float = parameter(
        0.004,
        "uncertainty of a rolling wheel's slip per acceleration of the car",
        unit="s^2/m",
        minimum=0.0,
        maximum=0.1,
    )
    radius_uncertainty: float = parameter(
        0.002, "uncertainty of all radii together, as a share: speed from wheels is no better", minimum=0.0, maximum=0.1
    )
    sensor_timeout: float = parameter(
        0.5, "silence of vehicle_velocity after which the wheels take over", unit="s", minimum=0.01, maximum=10.0
    )
    forget_after: float = parameter(
        1.0, "time without any sample after which the estimate starts again", unit="s", minimum=0.1, maximum=10.0
    )
    speed_filter: SpeedFilterParameters = group(SpeedFilterParameters())
    slide: SlideParameters = group(SlideParameters())
    sensor: SensorWatchParameters = group(SensorWatchParameters())
    slope: SlopeParameters = group(SlopeParameters())
    rolling: RollingParameters = group(RollingParameters())
    bounds: BoundParameters = group(BoundParameters())
