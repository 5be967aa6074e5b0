"""Calibrate the wheel radii over a bag and write them as a parameter file.

    python -m friction_bags calibrate_radii BAG --out radii.yaml [--parameters FILE] [--against sensor|wheels]

The bag needs a stretch of coasting. `sensor` takes vehicle_velocity for the truth (with speed_latency of the parameter
file); `wheels` equalises the wheels and keeps their mean radius. The file goes beside others: --params-file FILE.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import yaml
from rclpy.serialization import deserialize_message

from friction_bags.bag_format import BagError
from friction_bags.bag_reader import BagReader
from friction_runtime.aligner import AlignedInput, Aligner
from friction_runtime.parameters import ParameterError, load, per_wheel
from friction_runtime.processor import silent
from friction_runtime.stamps import NANOSECONDS, to_nanoseconds
from friction_runtime.wheel_speeds import WHEEL_STATES, WheelSpeeds
from wheel_slip.parameters import WheelSlipParameters
from wheel_slip.processor import VEHICLE_VELOCITY, CarProcessor
from wheel_slip.radius_calibration import CalibrationParameters, Radii, RadiusCalibration

_MAX_GAP = 0.3
"""Largest gap of the speed sensor [s] that is interpolated."""


def calibrate(
    messages: Iterator[tuple[str, Any]],
    parameters: WheelSlipParameters,
    use_sensor: bool,
    limits: CalibrationParameters,
) -> Radii | str:
    """Radii from the messages of a bag (relative topic, message), or the reason why there are none."""
    nominal = per_wheel("radii", parameters.radii, parameters.wheels)
    calibration = RadiusCalibration([nominal[wheel] for wheel in parameters.wheels], limits)
    inputs = [AlignedInput(VEHICLE_VELOCITY, _MAX_GAP)] if use_sensor else []
    aligner: Aligner[tuple[float, ...]] = Aligner(WHEEL_STATES, inputs, _MAX_GAP)
    wheel_speeds = WheelSpeeds(parameters.wheels, silent)
    latency = round(parameters.speed_latency * NANOSECONDS)
    for topic, message in messages:
        stamp = to_nanoseconds(message.header.stamp)
        if topic == WHEEL_STATES:
            aligner.offer_primary(stamp, wheel_speeds.read(message))
        elif topic == VEHICLE_VELOCITY and use_sensor:
            aligner.offer(topic, max(stamp - latency, 0), (message.twist.twist.linear.x,))
        for sample in aligner.ready():
            if not use_sensor:
                calibration.update(sample.stamp, sample.payload)
            elif VEHICLE_VELOCITY in sample.values:
                calibration.update(sample.stamp, sample.payload, sample.values[VEHICLE_VELOCITY][0])
    return calibration.result()


def bag_messages(bag: Path) -> Iterator[tuple[str, Any]]:
    """Yield (relative topic, message) of the wheel speeds and the speed sensor.

    Raises:
        BagError: the bag cannot be read, or has no wheel_states.
    """
    kinds = CarProcessor(WheelSlipParameters()).sensors
    with BagReader(bag) as reader:
        topics = [topic for topic in reader.counts if topic.name.lstrip("/") in (WHEEL_STATES, VEHICLE_VELOCITY)]
        if WHEEL_STATES not in {topic.name.lstrip("/") for topic in topics}:
            raise BagError(f"{bag} has no topic {WHEEL_STATES}")
        for topic, _, data in reader.messages(topics):
            name = topic.name.lstrip("/")
            yield name, deserialize_message(data, kinds[name])


def parameter_file(wheels: Sequence[str], found: Radii) -> str:
    """Text of the parameter file."""
    radii = [round(radius, 5) for radius in found.radii]
    document = {"/**/wheel_slip": {"ros__parameters": {"wheels": list(wheels), "radii": radii}}}
    deviations = ", ".join(f"{1e3 * stddev:.2f}" for stddev in found.stddevs)
    head = f"# Radii from {found.seconds:.1f} s of coasting; standard deviations {deviations} mm.\n"
    return head + yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("bag", type=Path, help="bag with wheel_states and, against the sensor, vehicle_velocity")
    parser.add_argument("--out", type=Path, required=True, help="parameter file to be written")
    parser.add_argument("--parameters", type=Path, help="parameter file with the wheels and their nominal radii")
    parser.add_argument("--against", choices=("sensor", "wheels"), default="sensor")
    limit = CalibrationParameters().max_acceleration
    parser.add_argument("--max-acceleration", type=float, default=limit, help="[m/s^2]")


def run(options: argparse.Namespace) -> int:
    """Calibrate; return the exit code: 0, 1 without a result, 2 for input that cannot be read."""
    limits = CalibrationParameters(max_acceleration=options.max_acceleration)
    try:
        given = options.parameters
        parameters = WheelSlipParameters() if given is None else load(WheelSlipParameters, given, "wheel_slip")
        found = calibrate(bag_messages(options.bag), parameters, options.against == "sensor", limits)
    except (BagError, ParameterError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if isinstance(found, str):
        print(f"error: {options.bag}: no radii: {found}", file=sys.stderr)
        return 1
    options.out.write_text(parameter_file(parameters.wheels, found), encoding="utf-8")
    for wheel, radius, stddev in zip(parameters.wheels, found.radii, found.stddevs, strict=True):
        print(f"{wheel}: {radius:.5f} m, standard deviation {1e3 * stddev:.2f} mm")
    return 0
