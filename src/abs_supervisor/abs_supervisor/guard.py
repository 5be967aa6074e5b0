"""Safety monitor between controller and brake of one wheel: envelope, wheel sensor and pressure checks.

Pure: no messages.
"""

from collections.abc import Sequence
from math import isfinite, nan
from typing import Final

from abs_supervisor.envelope import Envelope
from abs_supervisor.pressure_check import PressureCheck
from abs_supervisor.release_evidence import Wheel
from abs_supervisor.speed_trend import SpeedTrend
from abs_supervisor.tuning import EnvelopeTuning
from abs_supervisor.wheel_check import Surroundings, WheelCheck
from vehicle_models.brake_actuator import ActuatorParameters, Command
from vehicle_models.physical_bounds import SlowestCar
from vehicle_models.vehicle import CornerParameters

_BRAKED: Final = 20.0
"""[N m] below this, measured and demanded, a wheel rolls freely."""
_WITNESSES: Final = 2
"""Other wheels that must turn, for a wheel to be seen to slide."""
_MOVES: Final = 1.5
"""[m/s] of their circumferences; below it the ABS ends."""
_ALIKE: Final = 0.1
_ALIKE_STANDING: Final = 0.2
"""Wheels turn alike that differ by less than this share and [m/s]."""
_SLIDES: Final = 0.5
"""Share by which a sliding wheel turns slower."""
_STANDS: Final = 0.3
"""Of the least speed of the car by all of its wheels, below which a wheel stands, or nearly."""


class Seen:
    """What is known at one stamp; NaN where something is not."""

    def __init__(
        self,
        wheel_speed: float,
        torque: float,
        demand: float,
        others: Sequence[float] = (),
        slip: float = nan,
        slip_stddev: float = nan,
        car_speed: float = nan,
        car_is_measured: bool = False,
        lambda_max: float = nan,
        lambda_max_stddev: float = nan,
        slip_text: str = "slip is not known",
    ) -> None:
        """Hold what is known.

        Args:
            wheel_speed: [rad/s].
            torque: of the brake, measured [N m].
            demand: of the driver [N m].
            others: circumferential speeds of the other wheels, those that are known [m/s].
            slip: [-].
            slip_stddev: [-].
            car_speed: [m/s].
            car_is_measured: whether that speed comes from a speed sensor.
            lambda_max: [-].
            lambda_max_stddev: [-].
            slip_text: why the slip is not known.
        """
        self.wheel_speed = wheel_speed
        self.torque = torque
        self.demand = demand
        self.others = others
        self.slip = slip
        self.slip_stddev = slip_stddev
        self.car_speed = car_speed
        self.car_is_measured = car_is_measured
        self.lambda_max = lambda_max
        self.lambda_max_stddev = lambda_max_stddev
        self.slip_text = slip_text


class Guard:
    """Watches one wheel: `look` at every sample, then `command`."""

    def __init__(
        self, corner: CornerParameters, envelope: EnvelopeTuning, actuator: ActuatorParameters, commands: bool
    ) -> None:
        """Choose a wheel.

        Args:
            corner: radius, inertia and load of the wheel.
            envelope: parameters of evidence and caps.
            actuator: the hydraulics.
            commands: whether the brake obeys what `command` returns; else the pressure cannot be judged.
        """
        self.envelope = Envelope(corner, actuator, envelope)
        self._wheel = WheelCheck(corner)
        self._pressure = PressureCheck(actuator)
        self._commands = commands
        self._trend = SpeedTrend()
        self._slowest = SlowestCar()
        self._radius = corner.radius
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.envelope.reset()
        self._start()

    def restart(self) -> None:
        """Forget what lies before a jump back in time, and keep the counts."""
        self.envelope.restart()
        self._start()

    def _start(self) -> None:
        self._wheel.reset()
        self._pressure.reset()
        self._trend.reset()
        self._slowest.reset()
        self._car_speed = nan
        self._seen: Seen | None = None
        self.wheel_text = self.pressure_text = ""
        """What contradicts the wheel speed; what is wrong with the pressure. Empty where nothing is."""
        self.slides = False
        """Whether a wheel of unknown slip turns so much slower than others that its own speed is not the car's."""
        self.may_be_locked = False
        """Whether a lock of this wheel would look like a standstill of the car."""
        self.unchecked = ""
        """What could not be compared with anything independent."""

    @property
    def deceleration(self) -> float:
        """Of the car over the last 0.2 s [m/s^2]; NaN where unknown."""
        return self._trend.deceleration

    def look(self, stamp: int, seen: Seen) -> None:
        """Take what is known at a stamp [ns], later than the last. The wheel speed is finite."""
        self._seen = seen
        others = seen.others
        rims = sorted([self._radius * seen.wheel_speed, *others])
        # Wheels that all stand after a dive are locked: the car is not slow for that, whatever is made of their speeds.
        slowest = self._slowest.update(stamp, rims[-_WITNESSES if len(others) >= _WITNESSES else -1])
        known = isfinite(seen.car_speed) and (seen.car_is_measured or seen.car_speed > slowest)
        self._car_speed = seen.car_speed if known else slowest
        self._trend.update(stamp, self._car_speed if others or isfinite(seen.car_speed) else nan)
        strongest = seen.torque
        if isfinite(seen.demand) and not seen.demand <= strongest:
            strongest = seen.demand
        self.pressure_text, acting = "", strongest
        if self._commands and isfinite(seen.torque) and isfinite(seen.demand):
            self.pressure_text = self._pressure.update(stamp, seen.torque, seen.demand)
            if not self.pressure_text:
                acting = seen.torque
        around = Surroundings(acting, others, seen.car_speed, seen.car_is_measured)
        self.wheel_text = self._wheel.update(stamp, seen.wheel_speed, around)
        self.envelope.look(
            stamp,
            Wheel(
                speed=seen.wheel_speed,
                slip=seen.slip,
                slip_stddev=seen.slip_stddev,
                behind=self._behind(seen),
                lambda_max=seen.lambda_max,
                lambda_max_stddev=seen.lambda_max_stddev,
                car_deceleration=self._trend.deceleration,
                braked=not strongest < _BRAKED,
                alike=self._alike(seen),
                stands=self._stands(seen, slowest),
            ),
        )
        self.may_be_locked = not others and not isfinite(seen.car_speed)
        self.unchecked = self._what_is_unchecked(seen, bool(others))

    def _behind(self, seen: Seen) -> float:
        """Return the share by which a wheel of unknown slip turns slower than two others do, NaN where these stand.

        Two, as the sensor of one may be wrong.
        """
        self.slides = False
        if isfinite(seen.slip) or len(seen.others) < _WITNESSES:
            return nan
        car = sorted(seen.others)[-_WITNESSES]
        if not car > _MOVES:
            return nan
        behind = 1.0 - self._radius * seen.wheel_speed / car
        self.slides = behind > _SLIDES
        return behind

    def _alike(self, seen: Seen) -> bool:
        """Return whether two other wheels or more turn like this one, where no sensor measures the speed of the car."""
        if seen.car_is_measured or len(seen.others) < _WITNESSES:
            return False
        rim = self._radius * seen.wheel_speed
        apart = _ALIKE * abs(rim) + _ALIKE_STANDING
        return all(abs(each - rim) < apart for each in seen.others)

    def _stands(self, seen: Seen, slowest: float) -> bool:
        """Return whether this wheel and another stand, or nearly, while the car moves with `slowest` [m/s] at least.

        Two, as the sensor of one may be dead; by nothing but the wheels, as speed and slip may be wrong.
        """
        least = _STANDS * slowest
        return (
            slowest > _MOVES and self._radius * seen.wheel_speed < least and any(each < least for each in seen.others)
        )

    def command(self, stamp: int, law: Command, most: Command = Command.INCREASE, rolls: bool = False) -> Command:
        """Return the command that may be given for what the law asks at the stamp [ns] of the last `look`.

        `most` is what the other wheel of the axle leaves, of INCREASE (everything), HOLD and DECREASE; `rolls` whether
        it is the turn of this wheel to show the speed of the car.
        """
        seen = self._seen
        if seen is None:
            return Command.NONE
        asked = Command.NONE if self.wheel_text else law
        torque = seen.torque if isfinite(seen.torque) else 0.0
        demand = seen.demand if isfinite(seen.demand) else 0.0
        command = self.envelope.judge(stamp, asked, self._car_speed, torque, demand, rolls)
        if command is Command.INCREASE or (command is Command.HOLD and most is Command.DECREASE):
            command = most
        self.envelope.commanded(stamp, command, demand)
        self._pressure.commanded(stamp, demand, command)
        return command

    def _what_is_unchecked(self, seen: Seen, has_others: bool) -> str:
        missing = []
        if not isfinite(seen.slip):
            missing.append(f"release by deceleration alone ({seen.slip_text})")
        elif not isfinite(seen.lambda_max):
            missing.append("no friction curve")
        if not has_others:
            missing.append("no other wheel")
        if self.may_be_locked:
            missing.append("whether a wheel that stands is locked")
        if not isfinite(self._trend.deceleration):
            missing.append("deceleration of the car")
        if not self.envelope.evidence.scatter_is_learned:
            missing.append("scatter of the wheel rolling freely")
        if not self._commands:
            missing.append("pressure (the brake does not obey this node)")
        elif not (isfinite(seen.torque) and isfinite(seen.demand)):
            missing.append("pressure")
        return ", ".join(missing)
