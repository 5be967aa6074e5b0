"""Calibrate the wheel radii over a bag and write them into a vehicle file.

    python -m friction_bags calibrate_radii BAG --vehicle my_car.yaml --out my_car_calibrated.yaml
        [--params-file FILE] [--against sensor|wheels]

The bag needs a stretch of coasting. `sensor` takes vehicle_velocity as the truth (with wheel_slip's parameter
speed_sensor.latency); `wheels` equalises the wheels and keeps their mean radius. The new file is the old one with the
radius of each wheel and its standard deviation; everything else stays, including comments.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import JointState

from friction_bags.bag_io.bag_format import BagError
from friction_bags.bag_io.bag_reader import BagReader
from friction_bags.bag_io.cdr import decode
from friction_bags.bag_io.message_definition import type_name
from friction_bags.bag_vehicle import CAR_OTHERWISE, vehicle_for
from friction_bags.offline.estimators import read_parameters, vehicle_of
from friction_bags.offline.plan import SayOnce
from friction_bags.offline.vehicle_text import with_radii
from friction_parameters.command_line import positive
from friction_runtime.aligner import AlignedInput, Aligner
from friction_runtime.processor import Report
from friction_runtime.stamps import to_nanoseconds
from friction_runtime.wheel_speeds import WHEEL_STATES, WheelSpeeds
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_argument import add_vehicle_argument
from vehicle_models.vehicle_file import load_vehicle, vehicle_path
from wheel_slip.processor import VEHICLE_VELOCITY
from wheel_slip.radius_calibration import CalibrationParameters, Radii, RadiusCalibration

_MAX_GAP = 0.3
"""Largest gap of the speed sensor [s] that is interpolated."""
_KINDS = {WHEEL_STATES: JointState, VEHICLE_VELOCITY: TwistWithCovarianceStamped}


def calibrate(
    messages: Iterator[tuple[str, Any]],
    vehicle: Vehicle,
    speed_latency: float | None,
    limits: CalibrationParameters,
    report: Report,
) -> Radii | str:
    """Return the radii from the messages of a bag, or the reason why there are none.

    Args:
        messages: pairs of relative topic and message.
        vehicle: the car with its nominal radii.
        speed_latency: age of vehicle_velocity at its stamp [s]; None: compare the wheels with each other.
        limits: limits of coasting.
        report: log function; missing wheels are reported.
    """
    calibration = RadiusCalibration(vehicle.radii, limits)
    use_sensor = speed_latency is not None
    inputs = [AlignedInput(VEHICLE_VELOCITY, _MAX_GAP)] if use_sensor else []
    aligner: Aligner[tuple[float, ...]] = Aligner(WHEEL_STATES, inputs, _MAX_GAP)
    wheel_speeds = WheelSpeeds(vehicle, vehicle.wheel_names, report)
    latency = round((speed_latency or 0.0) * NANOSECONDS)
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


def bag_messages(reader: BagReader) -> Iterator[tuple[str, Any]]:
    """Yield (relative topic, message) of the wheel speeds and the speed sensor.

    Raises:
        BagError: the bag has no wheel_states of their type, or a message cannot be decoded.
    """
    kinds = {name: type_name(kind) for name, kind in _KINDS.items()}
    topics = [topic for topic in reader.counts if kinds.get(topic.name.lstrip("/")) == topic.type]
    if WHEEL_STATES not in {topic.name.lstrip("/") for topic in topics}:
        raise BagError(f"{reader.bag} has no topic {WHEEL_STATES}")
    for topic, _, data in reader.messages(topics):
        name = topic.name.lstrip("/")
        try:
            message = decode(data, _KINDS[name])
        except ValueError as error:
            raise BagError(f"{reader.bag}: {topic.name}: {error}") from error
        yield name, message


def calibrated_file(vehicle: Vehicle, source: Path, found: Radii) -> str:
    """Return the text of the new vehicle file.

    Raises:
        ParameterError: a radius is not plausible for a wheel.
    """
    radii = dict(zip(vehicle.wheel_names, zip(found.radii, found.stddevs, strict=True), strict=True))
    head = f"# Radii of the wheels are calibrated: {found.seconds:.1f} s of coasting.\n"
    text = head + with_radii(source.read_text(encoding="utf-8"), radii)
    with TemporaryDirectory() as directory:
        trial = Path(directory, source.name)
        trial.write_text(text, encoding="utf-8")
        load_vehicle(trial)
    return text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("bag", type=Path, help="bag with wheel_states and, against the sensor, vehicle_velocity")
    parser.add_argument("--out", type=Path, required=True, help="vehicle file to write: the car's, with new radii")
    add_vehicle_argument(parser, CAR_OTHERWISE)
    parser.add_argument("--params-file", type=Path, action="append", default=[], help="ROS parameter file; repeatable")
    parser.add_argument("--against", choices=("sensor", "wheels"), default="sensor")
    limit = CalibrationParameters().max_acceleration
    parser.add_argument("--max-acceleration", type=positive, default=limit, help="[m/s^2]")


def run(options: argparse.Namespace) -> int:
    """Calibrate; return the exit code: 0, 1 without a result.

    Raises:
        BagError: the bag cannot be read.
        ParameterError: a parameter or vehicle file is bad.
        OSError: the result cannot be written.
    """
    limits = CalibrationParameters(max_acceleration=options.max_acceleration)
    report = SayOnce()
    parameters = read_parameters(("wheel_slip",), options.params_file, report)
    latency = parameters["wheel_slip"].speed_sensor.latency if options.against == "sensor" else None
    with BagReader(options.bag) as reader:
        source = vehicle_path(vehicle_for(reader, options.vehicle, vehicle_of(parameters), report))
        vehicle = load_vehicle(source)
        found = calibrate(bag_messages(reader), vehicle, latency, limits, report)
    if isinstance(found, str):
        print(f"error: {options.bag}: no radii: {found}", file=sys.stderr)
        return 1
    options.out.write_text(calibrated_file(vehicle, source, found), encoding="utf-8")
    for wheel, radius, stddev in zip(vehicle.wheel_names, found.radii, found.stddevs, strict=True):
        print(f"{wheel}: {radius:.5f} m, standard deviation {1e3 * stddev:.2f} mm")
    return 0
