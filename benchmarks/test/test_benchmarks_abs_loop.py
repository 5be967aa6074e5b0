"""The closed-loop part: what it measures, checked on stops whose outcome is known."""

from argparse import Namespace
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.abs import law_rows
from benchmarks.abs.bounds import actuator_bound, car_bound, ideal_controller
from benchmarks.abs.car import CarSetup, car_parameters, car_stop
from benchmarks.abs.controllers import Parameters, law_stops, shipped
from benchmarks.abs.law_rows import COUPLINGS, SPLITS, largest_growth, split_setup
from benchmarks.abs.panic_stop import CAR_PERTURBATIONS, END_SPEED, NONE, PanicPlant, Perturbation
from benchmarks.abs.part import stops
from benchmarks.abs.random_cars import random_setup
from benchmarks.protocol import CAR, CORNER, SPEED, VEHICLE
from benchmarks.runner import load_part
from corner_sim.car.driving import peak_pressures
from friction_parameters.parameter import changed
from vehicle_models import burckhardt
from vehicle_models.surfaces import TABLE_8_1, surface
from vehicle_models.vehicle_file import load_vehicle


@pytest.fixture
def parameters() -> Parameters:
    return shipped()


def test_utilisation_is_the_mean_deceleration_over_the_best_one(parameters: Parameters) -> None:
    """mean(mu) g = (v0 - v1) / duration, by momentum."""
    for name in ("wet", "cobblestone"):
        found = stops(name, range(2), parameters)
        mu_max = float(burckhardt.peak(surface(name))[1])
        mean = (SPEED - END_SPEED) / found.duration / CORNER.gravity
        np.testing.assert_allclose(found.utilisation, mean / mu_max, rtol=0.02)
        assert np.all(found.distance > (SPEED**2 - END_SPEED**2) / (2.0 * mu_max * CORNER.gravity))


def test_shipped_parameters_hold_the_wheel_off_the_lock(parameters: Parameters) -> None:
    found = stops("dry", range(3), parameters)
    assert np.all(found.longest_lock < 0.05)
    assert np.all(found.utilisation > 0.5)
    assert np.all(found.fail_safes == 0)


def test_supervisor_that_never_releases_locks_the_wheel_and_it_is_noticed(parameters: Parameters) -> None:
    slope, supervisor = parameters
    thresholds = {"h_instability": -1e5, "release_timeout": 0.005, "wait": 0.0}
    never = (
        changed(slope, {"no_slip.eta_margin": 100.0}),
        changed(supervisor, {f"thresholds.{name}": value for name, value in thresholds.items()}),
    )
    found = stops("wet", range(1), never)
    assert found.longest_lock[0] > 0.05


def test_the_corner_is_that_of_the_vehicle_whatever_its_joints_are_called(parameters: Parameters) -> None:
    """Names do not matter, and a heavy wheel of little inertia stops as soon at the same friction."""
    (wheel,) = CAR.wheels
    renamed = replace(CAR, wheels=(replace(wheel, name="FL", joint="car::wheel_fl"),))
    alike, other = (
        stops("dry", range(1), parameters, vehicle=vehicle) for vehicle in (renamed, load_vehicle("bmw_m8"))
    )
    ours = stops("dry", range(1), parameters)
    assert alike.distance[0] == ours.distance[0]
    assert other.distance[0] == pytest.approx(ours.distance[0], rel=0.2)
    assert other.distance[0] != ours.distance[0]
    assert other.longest_lock[0] < 0.05


def test_runs_do_not_depend_on_their_neighbours_and_repeat(parameters: Parameters) -> None:
    together = stops("wet", range(3), parameters)
    alone = stops("wet", range(2, 3), parameters)
    assert together.utilisation[2] == pytest.approx(alone.utilisation[0], rel=1e-12)
    assert together.distance[2] == pytest.approx(alone.distance[0], rel=1e-12)
    assert together.transitions[2] == alone.transitions[0]


def test_every_run_that_ends_is_reported_once(parameters: Parameters) -> None:
    ended: list[int] = []
    stops("dry", range(3), parameters, ended.append)
    assert sum(ended) == 3


def test_part_gives_a_flat_row_for_each_surface_and_says_what_has_to_hold() -> None:
    rows = load_part("benchmarks", "abs").run(Namespace(seeds=1, vehicle=VEHICLE, law=None))
    assert [r["surface"] for r in rows if "passed" not in r] == list(TABLE_8_1)
    judged = [(r["surface"], r["quantity"]) for r in rows if "passed" in r]
    assert judged == [(name, quantity) for name in TABLE_8_1 for quantity in ("utilisation", "runs with lock")]
    for row in (r for r in rows if "passed" not in r):
        values = {r["quantity"]: r["value"] for r in rows if r["surface"] == row["surface"] and "passed" in r}
        assert values == {"utilisation": row["utilisation"], "runs with lock": row["runs_with_lock"]}
    assert all(isinstance(value, int | float | str) for r in rows for value in r.values())


@pytest.mark.parametrize(("name", "bound"), [("dry", 0.955), ("wet", 0.976), ("cobblestone", 0.959), ("snow", 0.998)])
def test_the_bound_of_the_brake_is_that_of_its_rate(name: str, bound: float) -> None:
    """The numbers were computed on another plant."""
    found = actuator_bound(name, NONE)
    assert found.utilisation == pytest.approx(bound, abs=1e-3)
    assert found.utilisation < found.utilisation_to_rest


def test_a_slower_or_later_brake_has_a_lower_bound() -> None:
    slow = actuator_bound("dry", Perturbation("slow", apply_rate=0.7)).utilisation
    assert slow < actuator_bound("dry", NONE).utilisation - 0.01
    late = actuator_bound("dry", Perturbation("late", delay=0.01)).utilisation
    assert slow < late < actuator_bound("dry", NONE).utilisation


def test_the_law_on_the_curve_comes_near_the_bound_without_a_speed_sensor_and_locks_no_wheel() -> None:
    found = law_stops("dry", range(2), "curve", NONE)
    assert np.all(found.utilisation > actuator_bound("dry", NONE).utilisation - 0.01)
    assert np.all(found.longest_lock < 0.05)
    assert np.all(found.stopped)
    assert np.all(found.changes < 80.0)


def test_a_brake_that_answers_late_is_learned_in_time_for_the_first_peak() -> None:
    """Without that it costs 0.06."""
    late = Perturbation("late", delay=0.02)
    found = law_stops("dry", range(1), "curve", late)
    assert found.utilisation[0] > actuator_bound("dry", late).utilisation - 0.01
    assert found.longest_lock[0] < 0.05


def test_the_ideal_controller_is_near_the_bound() -> None:
    for name in ("dry", "cobblestone"):
        assert ideal_controller(name, NONE).utilisation[0] > actuator_bound(name, NONE).utilisation - 0.005


def test_the_bound_of_a_car_is_that_of_its_rate_and_below_one() -> None:
    bound = car_bound(CarSetup("dry"))
    slow = car_bound(CarSetup("dry", Perturbation("slow", apply_rate=0.7)))
    assert 0.9 < bound.utilisation < bound.utilisation_to_rest < 1.0
    assert slow.utilisation < bound.utilisation - 0.01
    assert slow.distance > bound.distance


def test_the_demand_of_a_car_is_more_than_every_wheel_can_use() -> None:
    """On snow little load moves to the front, and the rear brakes are the weaker ones."""
    for name in TABLE_8_1:
        setup = CarSetup(name)
        pressures = peak_pressures(car_parameters(setup.vehicle, name))
        assert setup.demand / max(pressures) == pytest.approx(1.5)


def test_the_law_brings_a_car_of_four_wheels_near_its_bound_without_a_lock() -> None:
    options = Namespace(seeds=1, vehicle=VEHICLE, law="curve", car=["car"], surface=["dry"], case=["none"])
    (row,) = load_part("benchmarks", "abs").run(options)
    assert row["limit"] == row["bound"] - 0.01
    assert row["passed"], row["failures"]


def test_rows_of_the_law_say_what_has_to_hold() -> None:
    options = Namespace(seeds=1, vehicle=VEHICLE, law="curve", car=["corner"], surface=["wet"], case=["none"])
    (row,) = load_part("benchmarks", "abs").run(options)
    assert (row["surface"], row["case"], row["limit"]) == ("wet", "none", 0.972)
    assert row["passed"] == (not row["failures"])


def test_a_road_changes_at_a_distance_from_the_onset_and_the_demand_is_too_much_for_either_surface() -> None:
    plant = PanicPlant("snow to dry", NONE, np.zeros((2, 1)))
    increase = np.ones(2, dtype=np.int64)
    for _ in range(40):  # 6 m
        plant.advance(0.0, increase)
    snow, dry = surface("snow"), surface("dry")
    assert plant.demand == pytest.approx(1.5 * float(CORNER.peak_torque(dry)))
    while plant.braked_way[0] < 30.0:
        np.testing.assert_array_equal(plant.road(), [snow, snow])
        plant.advance(plant.demand, increase)
    np.testing.assert_array_equal(plant.road(), [dry, dry])
    np.testing.assert_allclose(plant.best_deceleration, float(burckhardt.peak(dry)[1]) * CORNER.gravity)


def test_the_ideal_controller_knows_of_a_change_and_a_brake_that_comes_down_too_slowly_locks_nevertheless() -> None:
    assert ideal_controller("snow to dry", NONE).utilisation[0] > 0.95
    locked = ideal_controller("dry to snow", NONE)
    assert locked.utilisation[0] > 0.95
    assert 0.08 < locked.longest_lock[0] < 0.14


def test_where_the_road_changes_the_row_compares_with_the_ideal_controller() -> None:
    options = Namespace(seeds=1, vehicle=VEHICLE, law="curve", car=["corner"], surface=["dry to wet"], case=["none"])
    (row,) = load_part("benchmarks", "abs").run(options)
    assert row["passed"], row["failures"]
    assert row["value"] == pytest.approx(row["distance_m"] / row["ideal_controller_distance_m"])
    assert row["limit"] == 1.04


def test_a_corner_that_differs_from_a_file_which_says_so_is_braked_at_its_bound() -> None:
    options = Namespace(seeds=1, vehicle=VEHICLE, law="curve", car=["corner"], surface=["wet"], case=["gain -20 %"])
    (row,) = load_part("benchmarks", "abs").run(options)
    assert row["passed"], row["failures"]


@pytest.mark.parametrize(("lock", "holds"), [(0.045, True), (0.05, False)])
def test_a_lock_where_the_road_changes_fails_its_row(lock: float, holds: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    locked = replace(law_stops("dry to wet", range(1), "curve", NONE), longest_lock=np.array([lock]))
    monkeypatch.setattr(law_rows, "law_stops", lambda *_: locked)
    (make,) = law_rows.chosen(["corner"], "curve", 1, ["dry to wet"], ["none"], judged=True)
    row = make()
    assert row["passed"] is holds
    assert ("lock" in row["failures"]) is not holds


def test_under_a_car_the_road_changes_after_the_onset_and_the_bound_locks_while_its_brakes_come_down() -> None:
    setup = CarSetup("dry to snow")
    assert setup.parameters.surfaces == ("dry", "snow")
    assert setup.parameters.surface_distances == (0.0, 120.0)  # 3 s of rolling, and 30 m
    assert setup.demand == CarSetup("dry").demand
    bound, dry = car_bound(setup), car_bound(CarSetup("dry"))
    assert dry.longest_lock == 0.0
    # 1900 N m at 5 kN m/s, less what turns a wheel on snow
    assert 0.25 < bound.longest_lock < 0.4
    assert dry.distance < bound.distance


def test_a_split_road_is_snow_on_the_right() -> None:
    setup = split_setup("dry | snow", COUPLINGS[-1])
    assert (setup.parameters.surfaces, setup.parameters.car.right_surface) == (("dry",), "snow")
    assert setup.nominal.front_yaw_moment_rate > 0.0
    assert {split_setup(road, COUPLINGS[0]).nominal.front_yaw_moment_rate for road in SPLITS} == {0.0}


@pytest.mark.parametrize("family", ["burckhardt", "pacejka"])
def test_slips_of_a_random_car_on_a_hill_are_within_their_intervals(family: str) -> None:
    """With white load noise, or an initial speed that is known for ever, they err by up to lambda_max."""
    stop = car_stop(random_setup(30_001, "wet", family), 30_001, "curve")
    assert np.mean(np.abs(stop.slip_error) < 1.96 * stop.slip_stddev) > 0.9
    assert np.sqrt(np.mean(stop.slip_error**2)) < 0.02


def test_a_random_car_is_the_same_on_each_road_and_another_for_each_seed() -> None:
    one, other = random_setup(1, "dry", "pacejka"), random_setup(1, "snow", "burckhardt")
    assert one.perturbation == other.perturbation
    assert one.parameters.car.tyre == "pacejka"
    assert one.vehicle.mass != random_setup(2, "dry", "pacejka").vehicle.mass != one.nominal.mass


def test_the_growth_of_a_moment_is_that_of_its_size_over_half_a_second() -> None:
    """-2000 N m/s for a second, then still; noise of one sample does not count fully."""
    moments = -2000.0 * np.minimum(0.005 * np.arange(400), 1.0)
    assert largest_growth(moments) == pytest.approx(2000.0)
    moments[300] -= 50.0
    assert largest_growth(moments) < 2200.0


@pytest.mark.parametrize(("name", "least"), [("hill -6 %", 0.95), ("hill +6 %", 0.93)])
def test_a_hill_that_begins_within_a_stop_on_snow_locks_no_wheel_and_leaves_the_brakes_on(
    name: str, least: float
) -> None:
    """Without a probe all wheels lock for ten seconds downhill, and lose 9 % of the brake uphill.

    Uphill the probe gives back a third of that: lambda_max was fitted to slips that were too small.
    """
    hill = next(each for each in CAR_PERTURBATIONS if each.name == name)
    found = car_stop(CarSetup("snow", hill), 30_000, "curve").stops
    assert found.stopped.all()
    assert found.longest_lock[0] < 0.05
    assert found.utilisation[0] > least
