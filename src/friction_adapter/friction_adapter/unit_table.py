"""Units by name, and a raw value as a value in SI units."""

from collections.abc import Callable
from dataclasses import dataclass
from math import nan, pi
from typing import Final

from vehicle_models.vehicle import Wheel

STANDARD_GRAVITY: Final = 9.80665
"""One g [m/s^2]."""
_KMH = 1.0 / 3.6
_TURN = 2.0 * pi
_MPH = 0.44704
_SPEED = {"m/s": 1.0, "km/h": _KMH, "mph": _MPH, "kn": 1852.0 / 3600.0}
EDGE_RATE: Final = "edges/s"
EDGES: Final = "edges"
"""A counter: what it becomes is an angle, whose rate is the speed."""
PERCENT: Final = "%"
_EDGES = {EDGE_RATE: _TURN, EDGES: _TURN}
UNITS: Final[dict[str, dict[str, float]]] = {
    "wheel_speed": {"rad/s": 1.0, "deg/s": pi / 180.0, "rpm": _TURN / 60.0, "rev/s": _TURN, **_EDGES, **_SPEED},
    "acceleration": {"m/s^2": 1.0, "g": STANDARD_GRAVITY},
    "yaw_rate": {"rad/s": 1.0, "deg/s": pi / 180.0},
    "speed": _SPEED,
    "pressure": {"Pa": 1.0, "kPa": 1e3, "bar": 1e5, "mbar": 1e2, "MPa": 1e6, "psi": 6894.757293168, PERCENT: 1e-2},
    "torque": {"N m": 1.0},
}
"""Factor to SI units by dimension and name; the SI unit comes first. That of edges is to be divided by the teeth,
that of a speed at the rim by the radius, that of % is to be multiplied by the full scale."""
_SPELLINGS = {
    "km/h": ("kph", "kmh", "kmph", "km/hr"),
    "mph": ("mi/h", "miles/h"),
    "m/s^2": ("m/s2", "m/s²", "m/s/s", "m/(s^2)", "mps2"),
    "m/s": ("mps",),
    "rad/s": ("rad/sec", "radps"),
    "deg/s": ("°/s", "deg/sec", "degree/s", "degrees/s"),
    "rpm": ("1/min", "rev/min", "u/min", "r/min"),
    "rev/s": ("rps",),
    "Pa": ("pascal",),
    "N m": ("nm", "n*m", "n.m", "n·m"),
    "%": ("percent",),
}
_CANONICAL = {
    spelling.lower(): name
    for name, spellings in (
        *((name, (name,)) for units in UNITS.values() for name in units),
        *_SPELLINGS.items(),
    )
    for spelling in spellings
    if name != "MPa"
}


def unit_named(text: str, dimension: str) -> str | None:
    """Return the name of a unit of a dimension as UNITS has it, None where there is none.

    Spellings differ between DBC files. Case counts in MPa only, as `mpa` is millipascal.
    """
    name = text.strip()
    name = name if name in UNITS[dimension] else _CANONICAL.get(name.lower(), "")
    return name if name in UNITS[dimension] else None


def is_rim_speed(dimension: str, unit: str) -> bool:
    """Whether a wheel speed in this unit is the speed of its rim."""
    return dimension == "wheel_speed" and unit in _SPEED


@dataclass(frozen=True)
class Conversion:
    """si = (raw scale + offset) factor / divisor."""

    factor: float
    divisor: float = 1.0
    scale: float = 1.0
    offset: float = 0.0

    def of_difference(self, difference: float) -> float:
        """Return a difference that is given in the unit, as a standard deviation is, in SI units."""
        return abs(difference * self.factor / self.divisor)

    def function(self) -> Callable[[float], float]:
        """Return the conversion of a raw value. Operations without effect are omitted, so no bit of a value is lost.

        A float32 of numpy would stay one in a product.
        """
        factor, divisor, scale, offset = self.factor, self.divisor, self.scale, self.offset
        if scale != 1.0 or offset != 0.0:
            return lambda raw: (float(raw) * scale + offset) * factor / divisor
        if divisor != 1.0:
            return lambda raw: float(raw) * factor / divisor
        if factor != 1.0:
            return lambda raw: float(raw) * factor
        return float


def conversion(
    dimension: str,
    unit: str,
    wheel: Wheel | None,
    *,
    scale: float = 1.0,
    offset: float = 0.0,
    sign: int = 1,
    full_scale: float = 1.0,
    radius: float = nan,
) -> Conversion:
    """Return how a raw value becomes one in SI units.

    Args:
        dimension: key of UNITS.
        unit: name of a unit there.
        wheel: wheel of the signal; its teeth are used for edges, its radius [m] for speeds at the rim.
        scale: the raw value times this, plus `offset`, is in `unit`.
        offset: see `scale`.
        sign: 1, or -1 where the signal counts the other way round.
        full_scale: 100 % in SI units.
        radius: by which the sender makes the speed of a rim [m]; NaN: that of the wheel.
    """
    factor = sign * UNITS[dimension][unit]
    if unit == PERCENT:
        factor *= full_scale
    divisor = 1.0
    if wheel is not None and is_rim_speed(dimension, unit):
        divisor = radius if radius == radius else wheel.radius
    elif wheel is not None and unit in _EDGES:
        divisor = float(wheel.encoder_teeth)
    return Conversion(factor, divisor, scale, offset)
