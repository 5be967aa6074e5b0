"""Simulated drives of the smart tyre: phases of the dynamic drive of Figure 8.20, calibration, estimates."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from corner_sim.smart_tyre.drives import CAR, HARD_BRAKING, Drive, dynamic_drive, quasi_static_drives
from corner_sim.smart_tyre.tyre_ring import TyreRing
from corner_sim.smart_tyre.tyre_signal import AccelerometerParameters, EncoderParameters, TyreBlock, TyreSignalSource
from smart_tyre_forces.calibrate import calibrate
from smart_tyre_forces.calibration import Calibration
from smart_tyre_forces.correction import Patch, PatchCorrection
from smart_tyre_forces.encoder_crossings import EncoderCrossings
from smart_tyre_forces.forces import Forces, forces
from smart_tyre_forces.front_template import FrontRefiner, FrontTemplate, TemplateLearner
from smart_tyre_forces.patch_tracker import Passage, PatchTracker, TrackerParameters
from smart_tyre_forces.tooth_table import ToothTable
from smart_tyre_forces.wheel_angle import WheelAngle
from smart_tyre_forces.wheel_run import WheelRun
from vehicle_models.reason import Reason
from vehicle_models.vehicle import FRONT, REAR, Wheel

Array = NDArray[np.float64]

PHASES: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "low speed": (6.0, 13.5),
        "acceleration": (15.0, 18.5),
        "cruise": (21.0, 41.0),
        "braking": (42.4, 43.5),
        "low speed again": (46.0, 59.0),
    }
)
"""Begin and end [s]."""
STEADY = ("low speed", "cruise", "low speed again")
"""Those of constant speed."""


def means(time: Array, values: Array) -> dict[str, float]:
    """Mean of `values` at `time` [s] in each phase, shapes (n,)."""
    return {phase: float(np.mean(values[(time > begin) & (time < end)])) for phase, (begin, end) in PHASES.items()}


TRACKER = TrackerParameters()
WHEEL = CAR.wheels[0]
"""The wheels of the car are alike but for their axle."""
RING = TyreRing()
NOMINAL, LOW = 2.0e5, 1.6e5
"""Gauge pressures of the chapter [Pa]."""
WHEEL_SEEDS = {FRONT: 1, REAR: 3}
"""One wheel of each axle, named after it, with its own teeth and mounting."""
PLANT_WHEELS = {name: seed for seed, name in enumerate(CAR.wheel_names)}
"""The wheels of corner_sim."""
CHAPTER_BRAKINGS = (HARD_BRAKING,) * 3
"""Decelerations of the dynamic drives that calibrate the tyres of the chapter [m/s^2]."""
PLANT_BRAKINGS = (HARD_BRAKING,) * 3 + (11.5,) * 5
"""The same for the tyres of corner_sim, whose car brakes with up to 11.7 m/s^2."""
_CALIBRATION_SEED = 1_000_000
"""Far from every seed of the evaluation."""


@dataclass(frozen=True)
class Sensors:
    """Noise of a case."""

    accelerometer: AccelerometerParameters = AccelerometerParameters()
    encoder: EncoderParameters = EncoderParameters()
    unevenness: float = 0.03


NOISY = Sensors()
QUIET = Sensors(AccelerometerParameters.ideal(), EncoderParameters.ideal(), unevenness=0.0)
QUIET_UNEVEN = replace(QUIET, unevenness=0.03)
ROUGH = replace(
    NOISY, accelerometer=replace(NOISY.accelerometer, texture_noise=6.0 * NOISY.accelerometer.texture_noise)
)
"""A road that shakes six times as much."""


def simulate(
    drive: Drive,
    wheel: str,
    seed: int,
    sensors: Sensors = NOISY,
    pressure: float = NOMINAL,
    wheel_seed: int | None = None,
) -> TyreBlock:
    """The signals of one wheel over a whole drive; `wheel_seed` is that of WHEEL_SEEDS unless given."""
    source = TyreSignalSource(
        RING,
        sensors.accelerometer,
        sensors.encoder,
        wheel_seed=WHEEL_SEEDS[wheel] if wheel_seed is None else wheel_seed,
        noise_seed=seed,
        pressure=pressure,
        sample_rate=TRACKER.sample_rate,
    )
    time = np.arange(0.0, drive.time[-1], 1.0 / TRACKER.sample_rate)

    def sampled(history: Array) -> Array:
        return np.asarray(np.interp(time, drive.time, history))

    fx, fz = wheel_history(drive, wheel)
    return source.advance(sampled(drive.speed) / RING.radius, sampled(fx), sampled(fz))


def wheel_of(name: str) -> Wheel:
    """Wheel of the car by name; for the name of an axle its left wheel, renamed after the axle."""
    if name in CAR.wheel_names:
        return CAR.wheel(name)
    return next(replace(each, name=name) for each in CAR.wheels if (each.axle, each.side) == (name, "left"))


def wheel_history(drive: Drive, wheel: str) -> tuple[Array, Array]:
    """True Fx and Fz [N] of one wheel over drive.time."""
    f = drive.forces
    return (f.fx_rear, f.fz_rear) if wheel_of(wheel).axle == REAR else (f.fx_front, f.fz_front)


def reference_load(drive: Drive, axle: str) -> Array:
    """Fz [N] by acceleration and load transfer alone."""
    return drive.smooth.fz_front if axle == FRONT else drive.smooth.fz_rear


def passages(block: TyreBlock, table: ToothTable | None, refiner: FrontRefiner | None = None) -> list[Passage]:
    """Passages of a whole drive."""
    wheel = WHEEL if table is None else replace(WHEEL, encoder_teeth=len(table) // 2)
    tracker = PatchTracker(wheel, TRACKER, table, refiner)
    return tracker.push(block.first_sample, block.encoder_voltage, block.radial_acceleration)


def wheel_angle(block: TyreBlock, table: ToothTable) -> WheelAngle:
    """Wheel angle over a whole drive."""
    wheel = WheelAngle(len(table) // 2, table)
    for stretch in EncoderCrossings(TRACKER.sample_rate).push(np.asarray(block.encoder_voltage, dtype=np.float64)):
        wheel.extend(stretch.times)
    return wheel


def learned_table(block: TyreBlock, teeth: int = WHEEL.encoder_teeth) -> ToothTable:
    """Tooth table learned from a drive.

    Raises:
        ValueError: the wheel never turned evenly enough.
    """
    tracker = PatchTracker(replace(WHEEL, encoder_teeth=teeth), TRACKER)
    tracker.push(block.first_sample, block.encoder_voltage, block.radial_acceleration)
    if tracker.wheel.table is None:
        raise ValueError("tooth table not learned")
    return tracker.wheel.table


@dataclass(frozen=True)
class CalibrationRuns:
    """Drives of one front and one rear wheel at nominal pressure, none of them used for evaluation."""

    quasi_static: list[WheelRun]
    dynamic: list[WheelRun]
    tables: dict[str, Array]
    template: FrontTemplate

    def calibrate(self) -> Calibration:
        """Calibrate as the calibration tool does."""
        return calibrate(self.quasi_static, self.dynamic, self.tables, CAR, TRACKER, template=self.template)


def calibration_runs(
    sensors: Sensors, wheel_seeds: Mapping[str, int] = WHEEL_SEEDS, brakings: Sequence[float] = CHAPTER_BRAKINGS
) -> CalibrationRuns:
    """Two quasi-static drives of each wheel, by the names of `wheel_of`, and a dynamic one for each deceleration."""
    uneven = sensors.unevenness
    slow = quasi_static_drives(road_seed=_CALIBRATION_SEED, unevenness=uneven)
    fast = [
        dynamic_drive(road_seed=_CALIBRATION_SEED + k, unevenness=uneven, braking=braking)
        for k, braking in enumerate(brakings, start=2)
    ]
    slow_runs, dynamic_runs, tables = [], [], {}
    learner = TemplateLearner()
    for wheel, wheel_seed in wheel_seeds.items():
        seed = _CALIBRATION_SEED + 10 * wheel_seed
        blocks = [simulate(drive, wheel, seed + k, sensors, wheel_seed=wheel_seed) for k, drive in enumerate(fast)]
        table = learned_table(blocks[0])
        tables[wheel] = table.deviations
        dynamic_runs += [_run(wheel, d, passages(b, table)) for d, b in zip(fast, blocks, strict=True)]
        for k, drive in enumerate(slow, start=len(fast)):
            block = simulate(drive, wheel, seed + k, sensors, wheel_seed=wheel_seed)
            slow_runs.append(_run(wheel, drive, passages(block, table, learner)))
    return CalibrationRuns(slow_runs, dynamic_runs, tables, learner.template)


def _run(wheel: str, drive: Drive, found: list[Passage]) -> WheelRun:
    return WheelRun(wheel_of(wheel), found, drive.time, drive.acceleration)


@dataclass(frozen=True)
class Estimated:
    """Valid revolutions of one drive, arrays of shape (n,), and the truth at the middle of each passage."""

    time: Array
    """[s]"""
    shift: Array
    """[rad]"""
    length: Array
    """[rad]"""
    fx: Array
    """[N]"""
    fz: Array
    fx_stddev: Array
    fz_stddev: Array
    fx_true: Array
    fz_true: Array
    fz_reference: Array
    revolutions: int
    """All of them, valid or not."""


def estimate(
    found: list[Passage], known: Calibration, drive: Drive, axle: str, *, rezero: bool = False, restore: bool = True
) -> Estimated:
    """Forces of a drive; with `rezero` the length is re-zeroed on its first steady stretch."""
    correction = PatchCorrection(known.tyre, WHEEL.radius, TRACKER.sample_rate)
    if rezero:
        correction.request_length_zero()
    valid: list[tuple[Patch, Forces]] = []
    for passage in found:
        patch = correction.update(passage)
        wheel = known.wheels[axle]
        force = forces(patch, known.tyre, wheel, correction.zero_speed, restore_steady=restore)
        if force.reason is Reason.OK:
            valid.append((patch, force))
    time = np.array([p.passage.time / TRACKER.sample_rate - 0.5 * p.length / p.passage.wheel_speed for p, _ in valid])
    fx, fz = wheel_history(drive, axle)
    return Estimated(
        time=time,
        shift=np.array([p.shift for p, _ in valid]),
        length=np.array([p.length for p, _ in valid]),
        fx=np.array([f.fx for _, f in valid]),
        fz=np.array([f.fz for _, f in valid]),
        fx_stddev=np.array([f.fx_stddev for _, f in valid]),
        fz_stddev=np.array([f.fz_stddev for _, f in valid]),
        fx_true=np.interp(time, drive.time, fx),
        fz_true=np.interp(time, drive.time, fz),
        fz_reference=np.interp(time, drive.time, reference_load(drive, axle)),
        revolutions=len(found),
    )
