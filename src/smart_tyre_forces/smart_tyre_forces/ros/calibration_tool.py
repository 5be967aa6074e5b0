"""calibrate_smart_tyre: bags in, a calibration file and its plots out."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from friction_parameters.command_line import command
from friction_parameters.parameter import ParameterError
from friction_parameters.parameter_file import load
from smart_tyre_forces import calibration_plots
from smart_tyre_forces.calibrate import calibrate, corrected_points, raw_points
from smart_tyre_forces.calibration import Calibration
from smart_tyre_forces.front_template import TemplateLearner
from smart_tyre_forces.parameters import SmartTyreParameters
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import add_vehicle_argument, load_vehicle, vehicle_choices


def main(arguments: Sequence[str] | None = None) -> int:
    """Calibrate; return the exit code: 0, or 2 where the bags do not allow it."""
    return command(lambda: _run(arguments), ValueError)


def _run(arguments: Sequence[str] | None) -> int:
    options = _parser().parse_args(arguments)
    parameters = SmartTyreParameters()
    if options.params_file is not None:
        parameters = load(SmartTyreParameters, options.params_file, "smart_tyre_forces")
    _calibrate(options, parameters)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="calibrate_smart_tyre", description=__doc__)
    parser.add_argument(
        "--quasi-static", type=Path, nargs="+", required=True, help="bags of very slow acceleration and coasting down"
    )
    parser.add_argument(
        "--dynamic",
        type=Path,
        nargs="+",
        required=True,
        help="bags that begin at constant low speed, then accelerate and brake hard",
    )
    parser.add_argument("--out", type=Path, required=True, help="calibration file to write")
    parser.add_argument("--plots", type=Path, help="directory for the plots")
    add_vehicle_argument(parser, "that of the bags, or of the parameter file")
    parser.add_argument("--params-file", type=Path, help="parameter file of smart_tyre_forces")
    parser.add_argument("--imu-topic", default="imu/data")
    return parser


def _vehicle(options: argparse.Namespace, by_file: str) -> Vehicle:
    """Return the car of the bags: the given one, else that in their notes, else that of the parameter file."""
    from smart_tyre_forces.ros.calibration_bags import noted_vehicle  # needs rosbags, which may be absent

    noted = sorted({name for bag in (*options.quasi_static, *options.dynamic) if (name := noted_vehicle(bag))})
    if not options.vehicle and len(noted) > 1:
        raise ParameterError(f"the bags are of different cars ({', '.join(noted)}): give --vehicle")
    chosen = options.vehicle or "".join(noted) or by_file
    if not chosen:
        raise ParameterError(f"the bags do not name their car: give --vehicle, {vehicle_choices()}")
    return load_vehicle(chosen)


def _calibrate(options: argparse.Namespace, parameters: SmartTyreParameters) -> None:
    from smart_tyre_forces.ros.calibration_bags import read

    tracker, zero = parameters.tracker, parameters.zero
    car = _vehicle(options, parameters.vehicle_file)
    slow = [read(bag, car, options.imu_topic) for bag in options.quasi_static]
    fast = [read(bag, car, options.imu_topic) for bag in options.dynamic]
    tables = {wheel: bag.table(car.wheel(wheel), tracker) for bag in reversed(fast) for wheel in bag.tyres}
    missing = sorted({wheel for bag in slow for wheel in bag.tyres} - set(tables))
    if missing:
        raise ValueError(f"wheels without a dynamic bag: {', '.join(missing)}")
    learner = TemplateLearner()
    slow_runs = [bag.run(car.wheel(w), tables[w], tracker, learner) for bag in slow for w in bag.tyres]
    fast_runs = [bag.run(car.wheel(w), tables[w], tracker) for bag in fast for w in bag.tyres]
    deviations = {wheel: table.deviations for wheel, table in tables.items()}
    known = calibrate(slow_runs, fast_runs, deviations, car, tracker, zero, learner.template)
    known.save(options.out)
    _show(known, options.out)
    if options.plots is not None:
        options.plots.mkdir(parents=True, exist_ok=True)
        slow_points = {f"{r.wheel.name}, run {k}": raw_points(r, car, tracker) for k, r in enumerate(slow_runs)}
        fast_points = {
            f"{r.wheel.name}, run {k}": corrected_points(r, known.tyre, known.wheels[r.wheel.name], car, tracker, zero)
            for k, r in enumerate(fast_runs)
        }
        calibration_plots.quasi_static_maps(slow_points, known.tyre, options.plots / "quasi_static_maps.png")
        calibration_plots.force_maps(fast_points, known.tyre, options.plots / "force_maps.png")


def _show(known: Calibration, file: Path) -> None:
    table = Table(title=str(file))
    table.add_column("quantity")
    table.add_column("value")
    table.add_row("wheels", ", ".join(known.wheels))
    table.add_row("beta [-]", f"{known.tyre.beta:.4f}")
    table.add_row("jitter of a front [rad]", f"{known.tyre.jitter_stddev:.5f}")
    for name, force in (("Fz", known.tyre.length_map), ("Fx", known.tyre.shift_map)):
        table.add_row(f"{name} valid from, to [N]", "{:.0f}, {:.0f}".format(*force.reach))
    for name, value in known.tyre.residuals.items():
        table.add_row(f"residual {name}", f"{value:.5f}")
    Console().print(table)


if __name__ == "__main__":
    sys.exit(main())
