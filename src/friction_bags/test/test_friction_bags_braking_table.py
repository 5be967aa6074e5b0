"""The table of brakings: what is common to the car is one line, and what is not known is no number."""

from __future__ import annotations

import csv
import json
from argparse import Namespace
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from friction_bags.__main__ import main
from friction_bags.results.braking_rows import Part, braking_rows
from friction_bags.results.braking_table import print_brakings, show_brakings
from friction_bags.results.recorded_run import WHY, RecordedRun, Series

TIME = np.arange(0.0, 6.0, 0.01)
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
SPEED = np.interp(TIME, [2.0, 4.0], [20.0, 4.0])
"""A braking with 8 m/s^2."""
BAGS = Path(__file__).parents[3] / "bags"
ABSENT = "waiting for the wheel to pass the peak"


def curve(lambda_max: float, valid_from: float = 2.5, mu_max_from: float = 10.0) -> Series:
    """Return friction curves that are valid from a time on; mu_max alone may be known before."""
    valid = np.where(valid_from - 0.005 < TIME, 1.0, 0.0)
    columns = {"lambda_max": lambda_max, "lambda_max_stddev": 0.01, "mu_max": 1.1, "mu_max_stddev": 0.02}
    arrays = {name: np.full(TIME.shape, value) for name, value in columns.items()}
    arrays["mu_max"][min(valid_from, mu_max_from) - 0.005 > TIME] = np.nan
    return Series(TIME, {**arrays, "valid": valid, WHY: 1.0 - valid}, Counter([ABSENT]))


def run_with(curves: dict[str, Series]) -> RecordedRun:
    """Return a braking run of four wheels with these friction curves, and a grip of 0.82 in it."""
    braked = (TIME > 2.0) & (TIME < 4.0)
    grip = {f"{of}.mu_used": np.where(braked, 0.82, 0.0) for of in ("vehicle", "front", "rear")}
    grip |= {f"{of}.mu_used_stddev": np.full(TIME.shape, 0.03) for of in ("vehicle", "front", "rear")}
    slip = {"slip": 0.1 * braked, "vehicle_speed": SPEED, "valid": np.ones(TIME.shape)}
    series = {f"{wheel}/friction_curve": each for wheel, each in curves.items()}
    return RecordedRun(WHEELS, 0, {**series, "front_left/slip": Series(TIME, slip), "grip": Series(TIME, grip)}, TIME)


def parts_of(curves: dict[str, Series]) -> dict[str, Part]:
    (row,) = braking_rows(run_with(curves))
    return {part.of: part for part in row.parts}


def printed(run: RecordedRun, width: int) -> str:
    console = Console(width=width, color_system=None)
    with console.capture() as capture:
        print_brakings(console, "drive", braking_rows(run))
    return capture.get()


def test_braking_has_its_decelerations_and_grip() -> None:
    (row,) = braking_rows(run_with({}))
    assert row.mean_deceleration == pytest.approx(8.0, rel=0.01)
    assert row.largest_deceleration == pytest.approx(8.0, rel=0.01)
    (part,) = row.parts
    assert (part.of, part.mu_used) == ("car", 0.82)


def test_wheels_with_one_curve_are_the_car_and_axles_or_sides_that_differ_have_lines_of_their_own() -> None:
    assert set(parts_of({wheel: curve(0.17) for wheel in WHEELS})) == {"car"}
    axles = parts_of({wheel: curve(0.17 if "front" in wheel else 0.15) for wheel in WHEELS})
    assert axles["front"].lambda_max == 0.17
    assert axles["rear"].lambda_max == 0.15
    sides = parts_of({wheel: curve(0.17 if "left" in wheel else 0.06) for wheel in WHEELS})
    assert set(sides) == {"car", "left", "right"}
    diagonal = parts_of({wheel: curve(0.17 if wheel in ("front_left", "rear_right") else 0.06) for wheel in WHEELS})
    assert set(diagonal) == {"car", "front_left, rear_right", "front_right, rear_left"}


def test_sides_of_a_split_road_have_their_own_truth_where_no_curve_was_valid() -> None:
    run = run_with({wheel: curve(0.17, valid_from=5.0) for wheel in WHEELS})
    truths = {f"truth/{wheel}/friction_curve": curve(0.17 if "left" in wheel else 0.06) for wheel in WHEELS}
    (row,) = braking_rows(RecordedRun(WHEELS, 0, {**run.series, **truths}, TIME))
    assert {part.of: part.true_lambda_max for part in row.parts[1:]} == {"left": 0.17, "right": 0.06}


def test_share_of_valid_curves_and_the_reason_where_none_was_are_given() -> None:
    known = parts_of({"front_left": curve(0.17, valid_from=3.0)})["car"]
    assert known.valid == pytest.approx(0.5, abs=0.06)
    assert known.reason == ""
    never = parts_of({"front_left": curve(0.17, valid_from=5.0)})["car"]
    assert never.valid == 0.0
    assert np.isnan(never.lambda_max)
    assert never.reason == ABSENT


def test_peak_is_that_of_the_most_certain_curve_and_not_of_the_last_one() -> None:
    series = curve(0.17)
    late = TIME > 3.5
    series.columns["mu_max"][late] = 1.3
    series.columns["lambda_max_stddev"][late] = 0.05
    known = parts_of({"front_left": series})["car"]
    assert (known.mu_max, known.lambda_max_stddev) == (1.1, 0.01)
    assert known.valid_at < 3.51


def test_mu_max_that_is_known_alone_stands_in_the_table_without_a_slip() -> None:
    text = printed(run_with({"front_left": curve(0.17, valid_from=5.0, mu_max_from=3.0)}), 80)
    assert "1.100±0.039 –" in text
    assert "0.170" not in text
    assert "no valid curve" in text


@pytest.mark.parametrize("width", [80, 100, 160])
def test_no_number_is_cut_at_any_width(width: int) -> None:
    curves = {wheel: curve(0.17 if "front" in wheel else 0.15) for wheel in WHEELS[:3]}
    text = printed(run_with({**curves, WHEELS[3]: curve(0.15, valid_from=5.0)}), width)
    for number in ("0.82±0.06", "1.100±0.039", "0.170±0.020", "0.150±0.020", "waiting for the wheel"):
        assert number in text
    assert "…" not in text
    assert max(map(len, text.splitlines()[:-1])) <= width


def test_drive_without_a_braking_has_a_sentence_in_place_of_a_table() -> None:
    assert "No braking" in printed(RecordedRun(WHEELS, 0, {}, TIME), 80)


def test_files_hold_the_ends_of_the_intervals_and_nothing_for_what_is_not_known(tmp_path: Path) -> None:
    rows = braking_rows(run_with({"front_left": curve(0.17), "front_right": curve(0.17, valid_from=5.0)}))
    options = Namespace(json=tmp_path / "rows.json", csv=tmp_path / "rows.csv")
    show_brakings(options, {"drive": rows}, Console(quiet=True))
    ((braking),) = json.loads(options.json.read_text())["brakings"]
    known = {part["of"]: part for part in braking["of"]}
    assert known["front_left"]["lambda_max_lower"] == pytest.approx(0.17 - 0.0196)
    assert known["front_right"]["lambda_max"] is None
    with options.csv.open(newline="") as file:
        lines = {line["of"]: line for line in csv.DictReader(file)}
    assert float(lines["front_left"]["mu_max_upper"]) == pytest.approx(1.1 + 0.0392)
    assert lines["front_right"]["mu_max"] == ""
    assert lines["front_right"]["reason"] == ABSENT


def test_process_ends_with_the_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "brakings.json"
    bag = str(BAGS / "abs_stop")
    assert main(["process", bag, "--out", str(tmp_path / "bag"), "--jobs", "1", "--json", str(file)]) == 0
    assert "Brakings of" in capsys.readouterr().out
    (braking,) = json.loads(file.read_text())["brakings"]
    (car,) = braking["of"]
    assert car["lambda_max_lower"] < 0.17 < car["lambda_max_upper"]
