"""The smart-tyre runs of the library: prescribed drives of section 8.4 with the signals of a front and a rear tyre."""

from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from friction_msgs.msg import TyreForce, TyreSignals, Validity
from numpy.typing import NDArray
from std_msgs.msg import Header

from corner_sim.smart_tyre.drives import Drive, dynamic_drive, quasi_static_drives
from corner_sim.smart_tyre.tyre_ring import TyreRing
from corner_sim.smart_tyre.tyre_signal import AccelerometerParameters, EncoderParameters, TyreSignalSource
from friction_runtime.messages import from_nanoseconds
from friction_runtime.processor import Output
from vehicle_models.nanoseconds import NANOSECONDS
from vehicle_models.vehicle_file import load_vehicle

Array = NDArray[np.float64]

VEHICLE = "smart_tyre_car"
_RATE = 10_000
"""Sample rate of the tyre signals [Hz]."""
_BLOCK = 50
"""Samples in a message: 5 ms."""
_ROAD_SEED = 7
_WHEEL_SEEDS = {"front_left": 1, "rear_left": 3}


@dataclass(frozen=True)
class TyreRun:
    """A drive at a tyre pressure."""

    note: str
    """Description of the run."""
    dynamic: bool
    """Whether it is the dynamic drive of Figure 8.20; else the slow acceleration of Figure 8.21."""
    pressure: float
    """Gauge pressure [Pa]."""
    cut: tuple[float, float]
    """Begin and end of the part that is kept in the repository [s]."""


def _run(dynamic: bool, pressure: float) -> TyreRun:
    what = (
        "dynamic smart-tyre run (Figure 8.20): 8 to 22 m/s and hard braking back"
        if dynamic
        else "quasi-static smart-tyre run (Figure 8.21): very slow acceleration from 8 to 25 m/s"
    )
    note = f"{what} at {pressure / 1e5:.1f} bar; a front and a rear wheel, true forces"
    return TyreRun(note, dynamic, pressure, (41.5, 44.0) if dynamic else (20.0, 22.5))


RUNS: dict[str, TyreRun] = {
    f"tyre_{'dynamic' if dynamic else 'quasi_static'}_{pressure / 1e5:.1f}_bar".replace(".", "_"): _run(
        dynamic, pressure
    )
    for dynamic in (False, True)
    for pressure in (2.0e5, 1.6e5)
}


def simulate(run: TyreRun, start_stamp: int, full: bool) -> Iterator[Output]:
    """Yield absolute topics and messages of a run, or of its cut; the drive begins at `start_stamp` [ns]."""
    drive = _drive(run.dynamic)
    time = np.arange(0.0, drive.time[-1] if full else run.cut[1], 1.0 / _RATE)
    first = 0 if full else round(run.cut[0] * _RATE)
    wheels = {wheel: _signals(run, drive, wheel, time) for wheel in _WHEEL_SEEDS}
    for begin in range(first, len(time) - _BLOCK + 1, _BLOCK):
        stamp = from_nanoseconds(start_stamp + begin * (NANOSECONDS // _RATE))
        for wheel, (encoder, acceleration) in wheels.items():
            header = Header(stamp=stamp, frame_id=wheel)
            fx, fz = (float(np.interp(time[begin], drive.time, each)) for each in _forces(drive, wheel))
            force = TyreForce(header=header, wheel=wheel, fx=fx, fz=fz, validity=Validity(valid=True))
            yield f"/truth/{wheel}/tyre_force", force
            yield (
                f"/{wheel}/tyre_signals",
                TyreSignals(
                    header=header,
                    wheel=wheel,
                    sample_rate=float(_RATE),
                    first_sample=begin,
                    encoder_voltage=array("f", encoder[begin : begin + _BLOCK].tobytes()),
                    radial_acceleration=array("f", acceleration[begin : begin + _BLOCK].tobytes()),
                    inflation_pressure=run.pressure,
                ),
            )


@cache
def _drive(dynamic: bool) -> Drive:
    car = load_vehicle(VEHICLE)
    return dynamic_drive(car, road_seed=_ROAD_SEED) if dynamic else quasi_static_drives(car, road_seed=_ROAD_SEED)[0]


def _forces(drive: Drive, wheel: str) -> tuple[Array, Array]:
    """Return true Fx and Fz [N] of a wheel over the time of the drive."""
    forces = drive.forces
    return (forces.fx_front, forces.fz_front) if wheel.startswith("front") else (forces.fx_rear, forces.fz_rear)


def _signals(run: TyreRun, drive: Drive, wheel: str, time: Array) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return encoder voltage [V] and radial acceleration [m/s^2] over `time`."""
    ring = TyreRing()
    source = TyreSignalSource(
        ring,
        AccelerometerParameters(),
        EncoderParameters(),
        wheel_seed=_WHEEL_SEEDS[wheel],
        noise_seed=_WHEEL_SEEDS[wheel],
        pressure=run.pressure,
        sample_rate=float(_RATE),
    )
    speed, fx, fz = (np.interp(time, drive.time, each) for each in (drive.speed, *_forces(drive, wheel)))
    block = source.advance(speed / ring.radius, fx, fz)
    return block.encoder_voltage.astype(np.float32), block.radial_acceleration.astype(np.float32)
