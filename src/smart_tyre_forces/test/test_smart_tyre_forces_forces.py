from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from corner_sim.smart_tyre.drives import Drive, dynamic_drive, quasi_static_drives
from corner_sim.smart_tyre.tyre_ring import TyreRing
from smart_tyre_forces.calibrate import calibrate
from smart_tyre_forces.calibration import Calibration, TyreCalibration, WheelCalibration, polynomial
from smart_tyre_forces.correction import Patch, PatchCorrection, ZeroParameters, load_shift
from smart_tyre_forces.force_map import ForceMap
from smart_tyre_forces.forces import forces, length_stddev, shift_stddev, steady_force
from smart_tyre_forces.front_template import GRID, FrontTemplate
from smart_tyre_forces.patch_tracker import Passage
from smart_tyre_forces.wheel_run import WheelRun
from vehicle_models.reason import Reason
from vehicle_models.vehicle import Vehicle
from vehicle_models.vehicle_file import load_vehicle

CAR = load_vehicle("smart_tyre_car")
RING = TyreRing()
LENGTH_MAP = ForceMap((0.1, 9.6e-5, -2.1e-9), 2500.0, 4800.0)
SHIFT_MAP = ForceMap((0.0, 1.3e-5, 0.0, -1e-13), -4000.0, 2200.0)
TYRE = TyreCalibration(
    shift_trend=(0.0, 9e-4, 2e-6),
    length_trend=(0.43, -1e-4, -2e-5),
    nominal_length=0.427,
    beta=0.08,
    jitter_stddev=2e-3,
    load_scatter=0.0,
    length_map=LENGTH_MAP,
    shift_map=SHIFT_MAP,
    trend_force=(0.0, -0.1, 0.065),
)
WHEEL = WheelCalibration(tuple(np.zeros(96)), (-44.0, 0.0, 0.0))


def passage(k: int, speed: float, centre: float, length: float, reference: int = 0) -> Passage:
    """Half a revolution into the table, four revolutions a second."""
    return Passage(
        k, 2500.0 * k, centre - 0.5 * length, centre + 0.5 * length, speed / 0.32, Reason.OK, reference, 1e-3
    )


def corrected(passages: list[Passage], tyre: TyreCalibration | None = TYRE) -> tuple[PatchCorrection, list[Patch]]:
    correction = PatchCorrection(tyre, 0.32, 1e4)
    return correction, [correction.update(p) for p in passages]


@given(force=st.floats(2500.0, 4800.0))
def test_force_map_inverts_itself(force: float) -> None:
    assert LENGTH_MAP.force(float(LENGTH_MAP.angle(force))) == pytest.approx(force, rel=1e-5)


@given(force=st.floats(-4000.0, 2200.0))
def test_slope_of_the_map_is_its_finite_difference(force: float) -> None:
    step = float(SHIFT_MAP.angle(force + 1.0) - SHIFT_MAP.angle(force - 1.0))
    assert SHIFT_MAP.slope(force) == pytest.approx(2.0 / step, rel=1e-4)


def test_map_does_not_extrapolate_far() -> None:
    assert np.isnan(LENGTH_MAP.force(float(LENGTH_MAP.angle(2500.0 - 0.4 * 2300.0))))
    assert np.isnan(LENGTH_MAP.force(10.0))


def test_fit_finds_the_map_and_is_not_biased_by_noise_of_the_angle() -> None:
    rng = np.random.default_rng(0)
    # Mostly cruising, as in a real drive: a fit of force over angle would be drawn towards the mean.
    force = np.concatenate((np.full(400, 3700.0), np.linspace(2600.0, 4800.0, 40)))
    angle = LENGTH_MAP.angle(force) + 0.01 * rng.standard_normal(len(force))
    fitted = ForceMap.fit(force, angle, (0, 1, 2))
    for value in (3000.0, 4500.0):
        assert fitted.force(float(LENGTH_MAP.angle(value))) == pytest.approx(value, abs=60.0)


@pytest.mark.parametrize(
    ("coefficients", "lowest", "highest"),
    [((0.0, -1e-5), 0.0, 1.0), ((0.0, 1e-5), 1.0, 1.0), ((0.0, np.nan), 0.0, 1.0)],
)
def test_maps_that_cannot_be_inverted_are_refused(
    coefficients: tuple[float, ...], lowest: float, highest: float
) -> None:
    with pytest.raises(ValueError, match="force map"):
        ForceMap(coefficients, lowest, highest)


def test_zero_is_found_on_the_first_slow_steady_stretch_of_seconds_and_not_before() -> None:
    correction, patches = corrected([passage(k, 8.0, 3.0, 0.43) for k in range(30)])
    ready = [p.reason is Reason.OK for p in patches]
    assert not any(ready[:16]) and all(ready[18:])
    assert patches[-1].shift == pytest.approx(0.0, abs=1e-12)
    assert patches[-1].alpha_2 - patches[-1].alpha_1 == pytest.approx(0.43)
    assert correction.zero_speed == pytest.approx(8.0)


def test_fast_or_unsteady_driving_gives_no_zero() -> None:
    for speeds in (np.full(60, 20.0), np.linspace(7.0, 12.0, 60)):
        _, patches = corrected([passage(k, v, 3.0, 0.43) for k, v in enumerate(speeds)])
        assert all(p.reason is Reason.NOT_READY for p in patches)


@given(centre=st.floats(0.0, 2.0 * np.pi), shift=st.floats(-0.06, 0.06))
def test_angles_about_the_wrap_of_the_wheel_are_no_problem(centre: float, shift: float) -> None:
    steady = [passage(k, 8.0, centre % (2.0 * np.pi), 0.43) for k in range(20)]
    _, patches = corrected([*steady, passage(20, 8.0, (centre + shift) % (2.0 * np.pi), 0.43)])
    assert patches[-1].shift_raw - patches[-2].shift_raw == pytest.approx(shift, abs=1e-9)


def test_speed_trends_and_cross_talk_are_taken_off() -> None:
    steady = [passage(k, 8.0, 3.0, polynomial(TYRE.length_trend, 8.0)) for k in range(20)]
    trend = polynomial(TYRE.shift_trend, 20.0) - polynomial(TYRE.shift_trend, 8.0)
    length = polynomial(TYRE.length_trend, 20.0) + 0.02
    _, patches = corrected([*steady, passage(20, 20.0, 3.0 + trend - TYRE.beta * 0.02, length)])
    assert patches[-1].shift == pytest.approx(0.0, abs=1e-12)
    assert patches[-1].length == pytest.approx(TYRE.nominal_length + 0.02)


def test_a_new_convention_of_zero_angle_needs_a_new_zero() -> None:
    first = [passage(k, 8.0, 3.0, 0.43) for k in range(20)]
    second = [passage(20 + k, 8.0, 1.0, 0.43, reference=1) for k in range(20)]
    _, patches = corrected(first + second)
    assert patches[19].reason is Reason.OK
    assert all(p.reason is Reason.NOT_READY for p in patches[20:35])
    assert patches[-1].reason is Reason.OK and patches[-1].shift == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("reason", "found"),
    [(Reason.GAP, True), (Reason.SATURATED, True), (Reason.SPEED_RANGE, False)],
)
def test_lost_revolutions_do_not_end_a_steady_stretch_but_a_change_of_speed_does(reason: Reason, found: bool) -> None:
    bad = Passage(9, 22_500.0, np.nan, np.nan, 25.0, reason, 0)
    drive = [*(passage(k, 8.0, 3.0, 0.43) for k in range(9)), bad, *(passage(k, 8.0, 3.0, 0.43) for k in range(10, 20))]
    _, patches = corrected(drive)
    assert patches[9].reason is reason and np.isnan(patches[9].shift)
    assert (patches[-1].reason is Reason.OK) == found


def test_a_zero_once_found_survives_invalid_revolutions() -> None:
    bad = Passage(20, 50_000.0, np.nan, np.nan, 5.0, Reason.SPEED_RANGE, 0)
    _, patches = corrected([*(passage(k, 8.0, 3.0, 0.43) for k in range(20)), bad, passage(21, 15.0, 3.0, 0.43)])
    assert patches[-1].reason is Reason.OK


def test_change_of_pressure_is_noticed_and_length_is_re_zeroed_on_request() -> None:
    nominal = polynomial(TYRE.length_trend, 8.0)
    correction, _ = corrected([passage(k, 8.0, 3.0, nominal) for k in range(20)])
    assert not correction.pressure_changed
    for k in range(20, 40):
        correction.update(passage(k, 8.0, 3.0, 1.07 * nominal))
    assert correction.pressure_changed
    patch = correction.update(passage(40, 8.0, 3.0, 1.07 * nominal))
    # The length is off by 7 %: the standard deviation shows it.
    assert length_stddev(TYRE, patch) == pytest.approx(0.07 * nominal, rel=0.02)
    correction.request_length_zero()
    patches = [correction.update(passage(k, 8.0, 3.0, 1.07 * nominal)) for k in range(41, 61)]
    assert patches[3].reason is Reason.NOT_READY
    assert patches[-1].reason is Reason.OK
    assert patches[-1].length == pytest.approx(TYRE.nominal_length)
    assert not correction.pressure_changed


def test_shift_is_re_zeroed_on_request_at_any_steady_speed() -> None:
    correction, _ = corrected([passage(k, 8.0, 3.0, 0.43) for k in range(20)])
    correction.request_shift_zero()
    patches = [correction.update(passage(k, 22.0, 3.2, 0.42)) for k in range(20, 40)]
    assert patches[-1].shift == pytest.approx(0.0, abs=1e-12)
    assert correction.zero_speed == pytest.approx(22.0)


def test_without_calibration_the_raw_values_are_given_and_called_so() -> None:
    _, patches = corrected([passage(k, 8.0, 3.0, 0.43) for k in range(20)], None)
    assert patches[-1].reason is Reason.NOT_CALIBRATED
    assert patches[-1].length == patches[-1].length_raw == pytest.approx(0.43)
    assert forces(patches[-1], None, None, 8.0, restore_steady=True).reason is Reason.NOT_CALIBRATED


def test_length_and_centre_are_those_of_the_chapter() -> None:
    found = passage(1, 8.0, 3.0, 0.43)
    assert found.length == pytest.approx(0.43)
    assert found.centre == pytest.approx(3.0)


def test_shift_by_the_load_is_linear_in_the_change_of_length() -> None:
    assert load_shift(TYRE, 0.0) == 0.0
    assert load_shift(TYRE, 0.02) == pytest.approx(0.08 * 0.02)


def good_patch(length: float, shift: float, speed: float = 20.0) -> Patch:
    return Patch(passage(1, speed, 3.0, length), Reason.OK, speed, length_raw=length, length=length, shift=shift)


def test_forces_follow_the_maps_and_the_steady_part_is_added_on_request() -> None:
    patch = good_patch(float(LENGTH_MAP.angle(4000.0)), float(SHIFT_MAP.angle(-1500.0)))
    bare = forces(patch, TYRE, WHEEL, 8.0, restore_steady=False)
    assert bare.fz == pytest.approx(4000.0, rel=1e-4)
    assert bare.fx == pytest.approx(-1500.0, rel=1e-4)
    full = forces(patch, TYRE, WHEEL, 8.0, restore_steady=True)
    assert full.fx - bare.fx == pytest.approx(-44.0 - 0.1 * 12.0 + 0.065 * (400.0 - 64.0))
    assert steady_force(TYRE, WHEEL, 8.0, 8.0) == pytest.approx(-44.0)


def test_deviations_are_those_of_two_independent_fronts() -> None:
    rng = np.random.default_rng(0)
    patch = good_patch(float(LENGTH_MAP.angle(4000.0)), float(SHIFT_MAP.angle(-1500.0)))
    jitter, noise = TYRE.jitter_stddev, patch.passage.front_stddev
    fronts = jitter * rng.standard_normal((2, 200_000)) + noise * rng.standard_normal((2, 200_000))
    length = fronts[1] - fronts[0]
    shift = 0.5 * (fronts[0] + fronts[1]) + TYRE.beta * length
    assert length_stddev(TYRE, patch) == pytest.approx(np.std(length), rel=0.01)
    assert shift_stddev(TYRE, patch) == pytest.approx(np.std(shift), rel=0.01)
    found = forces(patch, TYRE, WHEEL, 8.0, restore_steady=True)
    # The zero is a mean of the revolutions of 4 s at 8 m/s.
    revolutions = 4.0 * patch.passage.wheel_speed * 8.0 / 20.0 / (2.0 * np.pi)
    with_zero = shift_stddev(TYRE, patch) * np.sqrt(1.0 + 1.0 / revolutions)
    assert found.fx_stddev == pytest.approx(with_zero * SHIFT_MAP.slope(-1500.0), rel=1e-3)


def test_forces_refuse_what_they_cannot_know() -> None:
    far = good_patch(0.9, 0.0)
    assert forces(far, TYRE, WHEEL, 8.0, restore_steady=True).reason is Reason.OUT_OF_RANGE
    none = replace(far, reason=Reason.NO_FRONTS)
    found = forces(none, TYRE, WHEEL, 8.0, restore_steady=True)
    assert found.reason is Reason.NO_PATCH and np.isnan(found.fx) and np.isnan(found.fz)


def ideal_passages(drive: Drive, rear: bool) -> list[Passage]:
    """Fronts of a perfect detection: the laws of the tyre, every tenth of a second."""
    fx, fz = (drive.smooth.fx_rear, drive.smooth.fz_rear) if rear else (drive.smooth.fx_front, drive.smooth.fz_front)
    found = []
    for k, i in enumerate(range(0, len(drive.time), 100)):
        half = float(RING.patch_half_angle(fz[i], 2e5, drive.speed[i]))
        shift = float(RING.patch_shift(fx[i], fz[i], 2e5, drive.speed[i]))
        wheel_speed = drive.speed[i] / 0.32
        time = 1e4 * (drive.time[i] + half / wheel_speed)
        found.append(Passage(k, time, 3.0 + shift - half, 3.0 + shift + half, wheel_speed, Reason.OK, 0, 0.0))
    return found


def name_of(rear: bool) -> str:
    return "rear_left" if rear else "front_left"


TABLES = {name_of(rear): np.zeros(96) for rear in (False, True)}


@pytest.fixture(scope="module")
def calibrated() -> Calibration:
    slow, fast = [], []
    for rear in (False, True):
        wheel = CAR.wheel(name_of(rear))
        for drive in quasi_static_drives(road_seed=0, unevenness=0.0):
            slow.append(WheelRun(wheel, ideal_passages(drive, rear), drive.time, drive.acceleration))
        drive = dynamic_drive(road_seed=0, unevenness=0.0)
        fast.append(WheelRun(wheel, ideal_passages(drive, rear), drive.time, drive.acceleration))
    return calibrate(slow, fast, TABLES, CAR)


def test_calibration_from_perfect_fronts_finds_beta_and_the_laws_of_the_tyre(calibrated: Calibration) -> None:
    tyre = calibrated.tyre
    assert tyre.beta == pytest.approx(RING.cross_talk, abs=0.005)
    for fz in (2700.0, RING.static_load, 4700.0):
        longer = tyre.length_map.angle(fz) - tyre.length_map.angle(RING.static_load)
        expected = 2.0 * RING.half_patch * ((fz / RING.static_load) ** 0.7 - 1.0)
        assert np.degrees(longer) == pytest.approx(np.degrees(expected), abs=0.12)
    for fx in (-3500.0, 2000.0):
        expected = RING.patch_shift(fx, RING.static_load, 2e5, 0.0)
        assert np.degrees(tyre.shift_map.angle(fx)) == pytest.approx(np.degrees(expected), abs=0.05)


@pytest.mark.parametrize("rear", [False, True])
def test_calibrated_forces_are_the_true_ones(calibrated: Calibration, rear: bool) -> None:
    drive = dynamic_drive(road_seed=0, unevenness=0.0)
    correction = PatchCorrection(calibrated.tyre, 0.32, 1e4)
    wheel = calibrated.wheels[name_of(rear)]
    fx, fz = (drive.smooth.fx_rear, drive.smooth.fz_rear) if rear else (drive.smooth.fx_front, drive.smooth.fz_front)
    for p in ideal_passages(drive, rear):
        found = forces(correction.update(p), calibrated.tyre, wheel, correction.zero_speed, restore_steady=True)
        if found.reason is Reason.OK:
            i = round((p.time / 1e4 - 0.5 * (p.alpha_2 - p.alpha_1) / p.wheel_speed) * 1000)
            assert found.fz == pytest.approx(fz[i], abs=0.01 * RING.static_load)
            assert found.fx == pytest.approx(fx[i], abs=0.02 * RING.static_load)


def test_after_the_trends_every_constant_speed_has_the_same_length_and_shift(calibrated: Calibration) -> None:
    tyre = calibrated.tyre
    for speed in (10.0, 15.0, 20.0, 25.0):
        length = 2.0 * float(RING.patch_half_angle(RING.static_load, 2e5, speed))
        assert np.degrees(length - polynomial(tyre.length_trend, speed)) == pytest.approx(0.0, abs=0.2)


def undriven(car: Vehicle) -> Vehicle:
    return replace(car, wheels=tuple(replace(wheel, driven=False) for wheel in car.wheels))


def test_calibration_says_what_a_drive_lacks(calibrated: Calibration) -> None:
    drive = dynamic_drive(road_seed=0, unevenness=0.0)
    good = WheelRun(CAR.wheel("rear_left"), ideal_passages(drive, True), drive.time, drive.acceleration)
    with pytest.raises(ValueError, match="beta"):
        calibrate([good], [good], TABLES, CAR)
    slow = replace(good, passages=[p for p in good.passages if p.time < 1.3e5])
    with pytest.raises(ValueError, match="span"):
        calibrate([slow], [good], TABLES, CAR)
    with pytest.raises(ValueError, match="valid passages"):
        calibrate([replace(good, passages=[])], [good], TABLES, CAR)
    with pytest.raises(ValueError, match="driven"):
        calibrate([good], [good], TABLES, undriven(CAR))


def test_calibration_file_keeps_every_number(calibrated: Calibration, tmp_path: Path) -> None:
    shape = np.linspace(0.0, 1.0, len(GRID), dtype=np.float64)
    full = replace(calibrated, template=FrontTemplate(shape, shape[::-1].copy()))
    full.save(tmp_path / "c.yaml")
    loaded = Calibration.load(tmp_path / "c.yaml")
    assert loaded.tyre == full.tyre and loaded.wheels == full.wheels
    assert loaded.template is not None
    np.testing.assert_array_equal(loaded.template.trailing, shape[::-1])


@pytest.mark.parametrize(
    "damage",
    [
        lambda c: c.pop("tyre"),
        lambda c: c["tyre"].pop("beta"),
        lambda c: c["tyre"].update(beta="much"),
        lambda c: c["tyre"].update(beta=float("nan")),
        lambda c: c["tyre"].update(shift_trend=[1.0, 2.0]),
        lambda c: c["tyre"]["shift_map"].update(coefficients=[0.0, -1e-5]),
        lambda c: c["wheels"]["front_left"].update(tooth_table=[float("inf")] * 96),
        lambda c: c.update(template={"leading": [1.0], "trailing": [1.0]}),
    ],
)
def test_damaged_calibration_files_are_refused_by_name(calibrated: Calibration, tmp_path: Path, damage: object) -> None:
    calibrated.save(tmp_path / "c.yaml")
    content = yaml.safe_load((tmp_path / "c.yaml").read_text())
    damage(content)  # type: ignore[operator]
    (tmp_path / "c.yaml").write_text(yaml.safe_dump(content))
    with pytest.raises(ValueError, match=r"c\.yaml"):
        Calibration.load(tmp_path / "c.yaml")


def test_zero_parameters_decide_what_is_steady() -> None:
    correction = PatchCorrection(TYRE, 0.32, 1e4, ZeroParameters(duration=1.0))
    reasons = [correction.update(passage(k, 8.0, 3.0, 0.43)).reason for k in range(8)]
    assert reasons[3] is Reason.NOT_READY and reasons[-1] is Reason.OK
