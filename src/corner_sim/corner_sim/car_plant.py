"""The car of corner_sim.car as the plant of the node: vehicle file and parameters in, samples of the truth out."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from corner_sim.car.car import Car
from corner_sim.car.car_parameters import CarParameters, SensorParameters
from corner_sim.car.driving import peak_pressures
from corner_sim.car.measured_car import MeasuredCar
from corner_sim.car.tyres import FAMILIES, Burckhardt, Tyre
from corner_sim.driver import Throttle
from corner_sim.plant import SAMPLE_TIME, SLIP_MIN_SPEED, PlantSample
from corner_sim.road import Road
from corner_sim.sensors import Measurement, SensorNoise
from friction_parameters.parameter import constant, parameter
from vehicle_models.brake_actuator import ActuatorParameters, BrakeActuator
from vehicle_models.surfaces import SURFACES, surface
from vehicle_models.vehicle import Vehicle, four_wheels

Array = NDArray[np.float64]

CAR = "car"
"""Value of the parameter `model`."""
SAME = "same"
"""The right wheels are on the surfaces of the left ones."""


@dataclass(frozen=True)
class CarModelParameters:
    """Parameters of `model: car` that are not in the vehicle file: car, road and sensors."""

    tyre: str = parameter("burckhardt", "family of its tyres", choices=tuple(FAMILIES))
    load_variation: float = constant(0.0, "RMS of the load of each wheel over its mean, at 1 to 14 Hz")
    right_surface: str = parameter(
        SAME, "surface under the right wheels all the way; else the road's", choices=(SAME, *SURFACES)
    )
    slope: float = constant(0.0, "sine of the angle of the road, uphill positive")
    hill: float = constant(0.0, "sine of the additional angle of the road on a hill")
    hill_distance: float = constant(0.0, "where the hill begins", unit="m")
    hill_length: float = constant(30.0, "way to its full slope", unit="m")
    drive_speeds: tuple[float, ...] = parameter(
        (0.0,),
        "speeds that the driver drives at until he brakes; 0: in neutral",
        unit="m/s",
        minimum=0.0,
        maximum=150.0,
    )
    drive_times: tuple[float, ...] = parameter(
        (0.0,), "when each is reached, straight from one to the next", unit="s", minimum=0.0
    )
    fading: float = constant(0.0, "share of the brake gain lost when the pads have taken 100 kJ")
    damper_share: float = constant(
        0.0, "share of the dampers in the load transfer: 1 a sprung body, 0 a load that lags"
    )
    encoder: bool = parameter(False, "wheel speeds from the edges of the encoder's teeth, else ideal ones with noise")
    wheel_delay: float = constant(0.0, "age of a wheel speed at its stamp", unit="s")
    acceleration_delay: float = constant(0.0, "age of an acceleration at its stamp", unit="s")

    def hill_at(self, distance: float) -> float:
        """Return the sine of the angle of the hill at a distance [m]."""
        return self.hill * min(max((distance - self.hill_distance) / self.hill_length, 0.0), 1.0)


@dataclass(frozen=True)
class SensorErrors:
    """Errors of the sensors that every model has."""

    noise: SensorNoise
    acceleration_variance: float
    """[m^2/s^4]"""
    acceleration_bias: float
    """On top of that of the vehicle file [m/s^2]."""
    seed: int


def in_order(vehicle: Vehicle) -> Vehicle:
    """Return the vehicle with its wheels front left, front right, rear left, rear right.

    Raises:
        ValueError: the vehicle does not have these four.
    """
    try:
        return replace(vehicle, wheels=four_wheels(vehicle))
    except ValueError as error:
        raise ValueError(f"parameter 'model' = '{CAR}': {error}") from error


class CarPlant:
    """The car with one brake line per wheel on a road, and its sensors."""

    def __init__(
        self,
        vehicle: Vehicle,
        road: Road,
        parameters: CarModelParameters,
        actuator: ActuatorParameters,
        errors: SensorErrors,
        speed: float,
    ) -> None:
        """Put the car at the start of the road, rolling freely at `speed` [m/s], brakes released.

        Args:
            vehicle: with its wheels front left, front right, rear left, rear right.
            road: the surfaces, each one of a tyre.
            parameters: those that are not in the vehicle file.
            actuator: delay and rate limits of the hydraulics.
            errors: of the sensors.
            speed: at the start.

        Raises:
            ValueError: there is no tyre for a surface, the car stands, its rear wheels are not the driven ones, or the
                speeds of the drive do not fit its times.
        """
        family = FAMILIES[parameters.tyre]
        right = () if parameters.right_surface == SAME else (parameters.right_surface,)
        for which, names in (("surfaces", road.names), ("car.right_surface", right)):
            if unknown := [name for name in names if name in SURFACES and name not in family]:
                raise ValueError(f"parameter '{which}': 'model' = 'car' has {', '.join(family)}, not {unknown[0]}")
        if speed <= 0.0:
            raise ValueError(f"parameter 'initial_speed' = {speed} m/s: 'model' = 'car' needs a speed to begin with")
        if vehicle.engine_drag_torque and any(wheel.driven for wheel in vehicle.wheels[:2]):
            raise ValueError("'engine_drag_torque': 'model' = 'car' has it at the rear wheels, not at the front")
        self._vehicle, self._road = vehicle, road
        self._tyres: list[Tyre] = [family.get(name) or Burckhardt(*surface(name)) for name in (*road.names, *right)]
        self._right = len(road.names) if right else None
        self._lever = 0.5 * vehicle.track * np.array([1.0, -1.0, 1.0, -1.0])
        self._behind = np.array([0.0, 0.0, vehicle.wheelbase, vehicle.wheelbase])
        self._parameters = as_it_is(vehicle, self._tyres[0], parameters, errors)
        self._told = parameters
        self._measured = MeasuredCar(self._parameters, speed, errors.seed)
        self._put_on_the_road()
        self._speed_noise = np.random.default_rng([errors.seed, 4])
        self._speed_stddev = errors.noise.speed_variance**0.5
        self._gain = np.array([wheel.brake_gain for wheel in vehicle.wheels])
        self._actuator = BrakeActuator(4, SAMPLE_TIME, actuator)
        self._throttle = Throttle(
            parameters.drive_times, parameters.drive_speeds, vehicle.mass, vehicle.wheels[2].radius
        )
        self._index = 0

    @property
    def peak_torque(self) -> float:
        """Brake torque [N m] of the front left wheel at its peak while all wheels are at theirs."""
        return peak_pressures(self._parameters)[0] * float(self._gain[0])

    @property
    def _car(self) -> Car:
        return self._measured.car

    def sample(self) -> PlantSample:
        """Return the true state now. The slip of the truth is kinematic; friction and slope are at that of the tyre."""
        car = self._car
        surface = self._surface()
        slip, tyre_slip = np.array(car.slip), np.array(car.tyre_slip)
        slip_rate = np.full(4, np.nan)
        radius, inertia = np.array(self._parameters.radius), np.array(self._parameters.inertia)
        if car.speed > SLIP_MIN_SPEED:
            slip_rate = ((1.0 - slip) * car.acceleration - radius * np.array(car.wheel_acceleration)) / car.speed
        load = np.array(car.vertical_load)
        friction, slope = np.array([tyre.friction(each) for tyre, each in zip(car.tyres, car.tyre_slip, strict=True)]).T
        torque = self._actuator.torque * np.array(self._measured.brake_gain) / self._gain
        return PlantSample(
            index=self._index,
            speed=car.speed,
            acceleration=car.acceleration,
            distance=car.distance,
            wheel_speed=np.array(car.wheel_speed),
            brake_torque=torque,
            pressure_torque=self._actuator.torque.copy(),
            slip=slip,
            tyre_slip=tyre_slip,
            slip_rate=slip_rate,
            theta=np.array([_theta(tyre) for tyre in car.tyres]),
            peak=np.array([tyre.peak for tyre in car.tyres]),
            surface=surface,
            vertical_load=load,
            friction=friction,
            slope=slope,
            h=radius * load / inertia * slope * slip_rate,
            yaw_moment=float(self._lever @ (load * friction)),
        )

    def advance(self, demand_pressure: ArrayLike, command: ArrayLike) -> None:
        """Advance by one sample; arguments as in Plant.advance."""
        begin = self._actuator.torque / self._gain
        end = self._actuator.step(self._gain * np.asarray(demand_pressure, dtype=np.float64), command) / self._gain
        self._put_on_the_road()
        braking = bool(np.any(np.asarray(demand_pressure) > 0.0))
        engine = 0.0 if braking else self._throttle.torque(self._index * SAMPLE_TIME, self._car.speed)
        steps = self._measured.steps_per_sample
        slope = self._told.hill_at(self._car.distance)
        for k in range(steps):
            self._measured.step((begin + (k + 0.5) / steps * (end - begin)).tolist(), engine, slope)
        self._index += 1

    def measure(self, sample: PlantSample) -> Measurement:
        """Measure the present sample, once: encoders count from reading to reading."""
        found = self._measured.measure()
        return Measurement(
            wheel_speed=np.array(found.wheel_speed),
            brake_pressure=np.array(found.brake_pressure),
            speed=sample.speed + self._speed_stddev * float(self._speed_noise.standard_normal()),
            acceleration=self._vehicle.accelerometer.sign * found.acceleration,
        )

    def _put_on_the_road(self) -> None:
        self._car.tyres = [self._tyres[k] for k in self._surface()]

    def _surface(self) -> NDArray[np.int64]:
        surface = self._road.index(self._car.distance - self._behind)
        if self._right is not None:
            surface[1::2] = self._right
        return surface


def as_it_is(vehicle: Vehicle, tyre: Tyre, parameters: CarModelParameters, errors: SensorErrors) -> CarParameters:
    """The car of a vehicle file, whose values are taken as true and whose deviations are not used."""
    front_left, front_right, rear_left, rear_right = vehicle.wheels

    def each(name: str) -> tuple[float, float, float, float]:
        return (
            getattr(front_left, name),
            getattr(front_right, name),
            getattr(rear_left, name),
            getattr(rear_right, name),
        )

    accelerometer = vehicle.accelerometer
    noise = errors.noise.torque_variance**0.5
    gains = each("brake_gain")
    sensors = SensorParameters(
        sample_rate=round(1.0 / SAMPLE_TIME),
        encoder_teeth=front_left.encoder_teeth if parameters.encoder else 0,
        wheel_speed_variance=errors.noise.wheel_speed_variance,
        wheel_delay=parameters.wheel_delay,
        pressure_delay=vehicle.brake_pressure_delay,
        pressure_stddev=(noise / gains[0], noise / gains[1], noise / gains[2], noise / gains[3]),
        acceleration_delay=parameters.acceleration_delay,
        acceleration_bias=accelerometer.bias + errors.acceleration_bias,
        acceleration_scale=accelerometer.scale,
        acceleration_stddev=errors.acceleration_variance**0.5,
    )
    return CarParameters(
        tyres=(tyre,) * 4,
        mass=vehicle.mass,
        front_load_share=vehicle.front_load_share,
        wheelbase=vehicle.wheelbase,
        height=vehicle.centre_of_gravity_height,
        track=vehicle.track,
        drag_area=vehicle.drag_area,
        rolling_resistance=vehicle.rolling_resistance,
        radius=each("radius"),
        inertia=each("inertia"),
        brake_gain=gains,
        fading=parameters.fading,
        engine_drag=vehicle.engine_drag_torque,
        relaxation_length=each("relaxation_length"),
        damper_share=parameters.damper_share,
        pitch_gain=accelerometer.pitch_gain,
        load_variation=parameters.load_variation,
        slope=parameters.slope,
        sensors=sensors,
    )


def _theta(tyre: Tyre) -> tuple[float, float, float]:
    """Burckhardt parameters; NaN of another family."""
    theta: list[float] = [getattr(tyre, name, np.nan) for name in ("th1", "th2", "th3")]
    return theta[0], theta[1], theta[2]
