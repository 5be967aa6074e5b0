"""Files and tables made from the dataclass."""

from dataclasses import dataclass
from pathlib import Path

from friction_parameters.generated import ShippedFile, parameter_file, parameter_table
from friction_parameters.parameter import constant, constants, group, parameter
from friction_parameters.parameter_file import load


@dataclass(frozen=True)
class FilterParameters:
    density: float = parameter(3000.0, "bandwidth |q|", unit="rad^2/s^5", minimum=1.0)
    slowest: float = constant(1e-3, "speed of a wheel that stands", unit="rad/s")


@dataclass(frozen=True)
class Tuning:
    memory: float = constant(15.0, "way for which a release is remembered", unit="m")


@dataclass(frozen=True)
class DetectorParameters:
    window: int = parameter(6, "samples", minimum=3, maximum=2**31 - 1)
    wheel_filter: FilterParameters = group(FilterParameters())


@dataclass(frozen=True)
class NoSlipParameters:
    wait: bool = parameter(True, "wait for <wheel>/slip")


@dataclass(frozen=True)
class SlopeParameters:
    method: str = parameter("slip", "method", choices=("slip", "no_slip"), read_only=True)
    detector: DetectorParameters = group(DetectorParameters())
    no_slip: NoSlipParameters = group(NoSlipParameters(), selector="method", methods=("no_slip",))
    tuning: Tuning = constants(Tuning())
    car: str = parameter("", "the car")
    distances: tuple[float, ...] = parameter((0.0, 1e-7), "distances", unit="m", minimum=0.0)


SHIPPED = ShippedFile("Two\nlines.", SlopeParameters(detector=DetectorParameters(window=28)))


def test_file_holds_every_parameter_with_unit_range_and_the_methods_it_serves() -> None:
    assert parameter_file("slope", SHIPPED) == (
        "# Two\n"
        "# lines.\n"
        "# Written by `make docs` from the dataclass of the node: change it there.\n"
        "/**/slope:\n"
        "  ros__parameters:\n"
        '    method: "slip"                            # method (slip, no_slip); start only\n'
        "    detector:\n"
        "      window: 28                              # samples (3 to 2147483647)\n"
        "      wheel_filter:\n"
        "        density: 3000.0                       # [rad^2/s^5] bandwidth |q| (at least 1)\n"
        "    no_slip:                                  # only with method no_slip\n"
        "      wait: true                              # wait for <wheel>/slip\n"
        '    # car: ""                                 # the car\n'
        "    distances: [0.0, 1.0e-07]                 # [m] distances (at least 0)\n"
    )


def test_file_gives_back_what_it_was_made_from(tmp_path: Path) -> None:
    path = tmp_path / "slope.yaml"
    path.write_text(parameter_file("slope", SHIPPED))
    assert load(SlopeParameters, path, "slope") == SHIPPED.parameters


def test_table_holds_every_parameter_and_nothing_that_markdown_would_swallow() -> None:
    assert parameter_table(SHIPPED) == (
        "| parameter | shipped value | unit | range | |\n"
        "|---|---|---|---|---|\n"
        '| `method` | `"slip"` |  | slip, no_slip | method; start only |\n'
        "| `detector.window` | `28` |  | 3 to 2147483647 | samples |\n"
        "| `detector.wheel_filter.density` | `3000.0` | rad^2/s^5 | at least 1 | bandwidth \\|q\\| |\n"
        "| `no_slip.wait` | `true` |  |  | wait for \\<wheel>/slip; only with method no_slip |\n"
        '| `car` | `""` |  |  | the car |\n'
        "| `distances` | `[0.0, 1.0e-07]` | m | at least 0 | distances |\n"
    )
