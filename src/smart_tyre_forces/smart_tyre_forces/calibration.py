"""Calibration of a smart tyre, and its file."""

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from smart_tyre_forces.force_map import ForceMap
from smart_tyre_forces.front_template import FrontTemplate

Polynomial = tuple[float, float, float]
"""Second-order polynomial in the speed, lowest power first [unit / (m/s)^i]."""


def polynomial(coefficients: Polynomial, speed: float) -> float:
    """Return the value at `speed` [m/s]."""
    return coefficients[0] + speed * (coefficients[1] + speed * coefficients[2])


@dataclass(frozen=True)
class WheelCalibration:
    """Calibration of one wheel."""

    tooth_table: tuple[float, ...]
    """Deviations of the crossings [rad], shape (2 teeth,)."""
    steady_force: Polynomial
    """Fx of this wheel at constant speed [N]."""


@dataclass(frozen=True)
class TyreCalibration:
    """Calibration of one kind of tyre at one pressure: the same for front and rear."""

    shift_trend: Polynomial
    """Speed trend of the phase shift [rad], Figure 8.21a."""
    length_trend: Polynomial
    """Speed trend of the contact patch length [rad], Figure 8.21b."""
    nominal_length: float
    """Length at static load and rest (the trend at speed 0), to which every constant speed is brought [rad]."""
    beta: float
    """Cross-talk of (8.19) [-]."""
    jitter_stddev: float
    """Scatter of one front from revolution to revolution, beyond the noise of the signal [rad]."""
    load_scatter: float
    """Variance of the shift by a load that changes between the fronts, over the square of their time [rad^2/s^2]."""
    length_map: ForceMap
    """Fz over the corrected length, (8.14)."""
    shift_map: ForceMap
    """Fx, less what the speed trend removed, over the corrected shift, (8.16)."""
    trend_force: Polynomial
    """Fx that the common speed trend removes with it: drag and rolling resistance, mean of both axles [N]."""
    residuals: dict[str, float] = field(default_factory=dict)
    """RMS residual of each fit, with its unit in the name."""


@dataclass(frozen=True)
class Calibration:
    """Content of a calibration file."""

    tyre: TyreCalibration
    wheels: dict[str, WheelCalibration]
    template: FrontTemplate | None = None

    def save(self, path: Path) -> None:
        """Write the file; numbers survive exactly."""
        content: dict[str, Any] = {
            "tyre": _plain(asdict(self.tyre)),
            "wheels": {name: _plain(asdict(wheel)) for name, wheel in self.wheels.items()},
        }
        if self.template is not None:
            content["template"] = {
                "leading": self.template.leading.tolist(),
                "trailing": self.template.trailing.tolist(),
            }
        path.write_text(yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=120))

    @classmethod
    def load(cls, path: Path) -> "Calibration":
        """Read the file.

        Raises:
            OSError: it cannot be read.
            ValueError: an entry is missing, of the wrong kind or not finite; the message names the file.
        """
        try:
            content = yaml.safe_load(path.read_text())
            tyre = dict(content["tyre"])
            for name in ("length_map", "shift_map"):
                entry = tyre[name]
                tyre[name] = ForceMap(_numbers(entry["coefficients"]), float(entry["lowest"]), float(entry["highest"]))
            for name in ("shift_trend", "length_trend", "trend_force"):
                tyre[name] = _second_order(tyre[name])
            for name in ("nominal_length", "beta", "jitter_stddev", "load_scatter"):
                tyre[name] = _numbers([tyre[name]])[0]
            wheels = {
                name: WheelCalibration(_numbers(wheel["tooth_table"]), _second_order(wheel["steady_force"]))
                for name, wheel in content["wheels"].items()
            }
            shapes = content.get("template")
            template = None
            if shapes is not None:
                template = FrontTemplate(np.asarray(shapes["leading"], float), np.asarray(shapes["trailing"], float))
            return cls(TyreCalibration(**tyre), wheels, template)
        except (KeyError, TypeError, AttributeError, ValueError, yaml.YAMLError) as problem:
            raise ValueError(f"calibration file {path}: {problem!r}") from problem


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    return [_plain(entry) for entry in value] if isinstance(value, tuple) else value


def _numbers(values: Any) -> tuple[float, ...]:
    numbers = tuple(float(value) for value in values)
    if not np.all(np.isfinite(numbers)):
        raise ValueError(f"not finite: {numbers}")
    return numbers


def _second_order(values: Any) -> Polynomial:
    constant, linear, square = _numbers(values)
    return constant, linear, square
