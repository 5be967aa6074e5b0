"""Parameters of smart_tyre_forces: of the node, the bag runner, the calibration tool and the parameter file."""

from dataclasses import dataclass

from friction_runtime.parameters import parameter
from smart_tyre_forces.correction import ZeroParameters
from smart_tyre_forces.encoder_crossings import CrossingParameters
from smart_tyre_forces.patch_tracker import TrackerParameters


@dataclass(frozen=True)
class SmartTyreParameters:
    """All of them, with unit and range."""

    wheels: tuple[str, ...] = parameter(("front_left",), "names of the wheels", read_only=True)
    calibration_file: str = parameter("", "calibration made by the calibration tool; empty: raw contact patches only")
    front_method: str = parameter(
        "crossing", "crossing of a level, or matched template of the calibration", choices=("crossing", "template")
    )
    restore_steady_force: bool = parameter(
        True, "add to fx the steady drag and rolling part that the speed trend removes"
    )
    publish_wrench: bool = parameter(False, "publish <wheel>/tyre_wrench beside tyre_force", read_only=True)
    sample_rate: float = parameter(1e4, "of the tyre signals", unit="Hz", minimum=5e3, maximum=1e5)
    tyre_radius: float = parameter(0.32, "from wheel speed to road speed", unit="m", minimum=0.05, maximum=2.0)
    teeth: int = parameter(48, "of the encoder", minimum=24, maximum=200)
    encoder_hysteresis: float = parameter(
        0.1, "voltage to be passed on either side of a zero crossing", unit="V", minimum=1e-4, maximum=100.0
    )
    interval_ratio: float = parameter(
        1.5, "neighbouring crossing intervals differing by more: a missed tooth", minimum=1.1, maximum=3.0
    )
    acceleration_range: float = parameter(
        4905.0, "saturation of the accelerometer", unit="m/s^2", minimum=100.0, maximum=1e5
    )
    minimum_speed: float = parameter(5.0, "no contact patch below", unit="m/s", minimum=3.0, maximum=50.0)
    maximum_speed: float = parameter(35.0, "no contact patch above", unit="m/s", minimum=5.0, maximum=100.0)
    zero_duration: float = parameter(4.0, "of a stretch of constant speed", unit="s", minimum=0.5, maximum=60.0)
    zero_speed_spread: float = parameter(
        0.03, "highest over lowest speed of such a stretch, less one", minimum=1e-3, maximum=0.2
    )
    zero_maximum_speed: float = parameter(
        12.0, "of the first stretch, which gives zero shift", unit="m/s", minimum=5.0, maximum=50.0
    )
    pressure_tolerance: float = parameter(
        0.04, "change of contact patch length at constant speed that is reported", minimum=0.005, maximum=0.5
    )

    def __post_init__(self) -> None:
        """Refuse combinations that make no sense."""
        if not self.maximum_speed > self.minimum_speed:
            raise ValueError("parameter 'maximum_speed' must exceed 'minimum_speed'")
        if self.front_method == "template" and not self.calibration_file:
            raise ValueError("parameter 'front_method' = 'template' needs 'calibration_file'")

    def tracker(self) -> TrackerParameters:
        """Of the sensors."""
        return TrackerParameters(
            sample_rate=self.sample_rate,
            teeth=self.teeth,
            radius=self.tyre_radius,
            minimum_speed=self.minimum_speed,
            maximum_speed=self.maximum_speed,
            acceleration_range=self.acceleration_range,
            crossings=CrossingParameters(
                hysteresis=self.encoder_hysteresis,
                longest_interval=round(0.033 * self.sample_rate),
                interval_ratio=self.interval_ratio,
            ),
        )

    def zero(self) -> ZeroParameters:
        """Of steady stretches."""
        return ZeroParameters(
            duration=self.zero_duration,
            speed_spread=self.zero_speed_spread,
            maximum_speed=self.zero_maximum_speed,
            pressure_tolerance=self.pressure_tolerance,
        )
