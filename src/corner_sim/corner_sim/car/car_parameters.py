"""True parameters of the simulated car: body, wheels, brakes and sensors."""

from dataclasses import dataclass, field
from math import radians

from corner_sim.car.tyres import TYRES, Tyre

WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
"""Wheels in the order of every array."""
Four = tuple[float, float, float, float]


@dataclass(frozen=True)
class SensorParameters:
    """The sensors, with their errors."""

    sample_rate: int = 200
    """Rate of the recording [Hz], a divisor of 1000."""
    encoder_teeth: int = 0
    """Teeth of the encoders, missing ones included; 0: ideal wheel speeds with white noise."""
    missing_teeth: int = 0
    """Teeth in a row that each ring lacks, unknown to the control unit."""
    wheel_speed_variance: float = 0.005
    """Variance of ideal wheel speeds [rad^2/s^2], as section 8.3.2."""
    wheel_delay: float = 0.0
    """Time by which wheel speeds are older than their stamp [s]."""
    pressure_delay: float = 0.0
    """Time by which a pressure is older than its stamp, or the torque ahead of it [s]."""
    pressure_lag: float = 0.0
    """Time constant of the pressure sensor behind the torque [s]."""
    pressure_stddev: Four = (2.5e4,) * 4
    """White noise of the pressures [Pa]."""
    acceleration_delay: float = 0.0
    """Time by which an acceleration is older than its stamp [s]."""
    acceleration_bias: float = 0.0
    """[m/s^2]"""
    acceleration_scale: float = 1.0
    """Change of the reading over change of specific force."""
    acceleration_stddev: float = 0.05
    """White noise of the accelerometer [m/s^2]."""


@dataclass(frozen=True)
class CarParameters:
    """A compact car, its rear wheels driven; the defaults are its nominal values without any perturbation."""

    tyres: tuple[Tyre, Tyre, Tyre, Tyre] = (TYRES["burckhardt"]["dry"],) * 4
    """Tyre of each wheel on its road."""
    mass: float = 1500.0
    """[kg]"""
    front_load_share: float = 0.5
    """Share of the weight on the front axle at rest."""
    wheelbase: float = 2.7
    """[m]"""
    height: float = 0.5
    """Height of the centre of gravity [m]; 0: no load transfer."""
    track: float = 1.5
    """[m]"""
    front_roll_stiffness: float = 0.56
    """Share of the roll moment that the front axle takes [-]; in CorneringCar, as the two that follow."""
    gyration: float = 0.95
    """Yaw inertia over that of masses at the axles [-]."""
    across: float = 0.9
    """Friction of a tyre across over that along [-]."""
    drag_area: float = 0.65
    """[m^2]"""
    rolling_resistance: float = 0.012
    """Coefficient; the force acts on the body, as the effective radius is that of the freely rolling wheel."""
    radius: Four = (0.3,) * 4
    """Effective rolling radii at rest [m]."""
    radius_loss: float = 0.0
    """Share of it that is lost where the load of the wheel doubles."""
    inertia: Four = (1.0,) * 4
    """Wheel inertias [kg m^2]."""
    brake_gain: Four = (1.3e-4, 1.3e-4, 0.7e-4, 0.7e-4)
    """Torque over pressure when cold [N m/Pa]."""
    fading: float = 0.0
    """Share of the gain lost when pads have taken `fading_energy`, in [0, 1)."""
    fading_energy: float = 1.0e5
    """Work of one brake over which the gain falls linearly to 1 - fading [J]."""
    engine_drag: float = 0.0
    """Torque of the closed throttle at each rear wheel [N m], braking positive."""
    relaxation_length: Four = (1e-3,) * 4
    """Lengths sigma over which the slips of the tyres follow the kinematic slips [m], > 0."""
    carcass_damping: float = 1e-3
    """Time constant of the tyre's own damping [s]: the longitudinal mode near 40 Hz has 10 % of damping by it."""
    pitch_frequency: float = 1.6
    """Natural frequency of pitch [Hz]."""
    pitch_damping: float = 0.5
    """Its damping ratio."""
    damper_share: float = 0.0
    """Share of the dampers' force in the load transfer: 1 a sprung body, 0 a load that lags as the pitch angle does."""
    pitch_gain: float = 0.0
    """Pitch, nose down, over steady deceleration [rad s^2/m]; see PITCH_GAIN."""
    load_variation: float = 0.0
    """RMS of the load of each wheel over its mean, by the unevenness of the road."""
    load_sensitivity: float = 0.0
    """Share of its friction that a tyre loses where its load, without the road's unevenness, is twice that at rest."""
    slope: float = 0.0
    """Sine of the angle of the road, uphill positive."""
    sensors: SensorParameters = field(default_factory=SensorParameters)


PITCH_GAIN = radians(0.15)
"""A common pitch [rad s^2/m]."""
