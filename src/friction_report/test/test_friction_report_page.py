"""The page of a drive holds the contents of the bag, names what is missing, and runs no code from it."""

from __future__ import annotations

import json
import re
from collections import Counter
from html.parser import HTMLParser
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from friction_msgs.msg import FrictionCurve, FrictionSlope, TyreForce, Validity, WheelSlip
from geometry_msgs.msg import TwistWithCovarianceStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from friction_bags.bag_io.bag_writer import write_bag
from friction_bags.offline.plan import ProcessOptions
from friction_bags.offline.run import process_bag
from friction_bags.results.recorded_run import WHY, RecordedRun, Series
from friction_bags.results.run_reader import read_run
from friction_report.__main__ import main
from friction_report.page import PANELS, html_page, page_data, write_page
from friction_report.signals import points_of
from friction_runtime.messages import header_at

BAGS = Path(__file__).parents[3] / "bags"
WEB = files("friction_report").joinpath("web")
OURS = "".join(file.read_text() for file in WEB.iterdir() if file.name.endswith(".js") and "uPlot" not in file.name)
HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>"


class Elements(HTMLParser):
    """Elements of a page: tags with their attributes, and the text of each script."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag == "script":
            self.scripts.append("")

    def handle_data(self, data: str) -> None:
        if self.tags and self.tags[-1][0] == "script":
            self.scripts[-1] += data


def shown(page: str) -> dict[str, Any]:
    """Return the data of a page."""
    data: dict[str, Any] = json.loads(Elements(page).scripts[0])
    return data


def values(line: dict[str, Any]) -> list[float]:
    return [each / line["unit"] for each in line["v"] if each is not None]


@pytest.fixture(scope="module")
def stop(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Page of a recorded stop with estimates."""
    out = tmp_path_factory.mktemp("page") / "page.html"
    assert main([str(BAGS / "abs_stop"), "--out", str(out)]) == 0
    return out.read_text()


def test_page_needs_nothing_but_itself(stop: str) -> None:
    elements = Elements(stop)
    assert not [tag for tag, _ in elements.tags if tag in ("link", "img", "iframe", "base", "object")]
    assert not [given for _, given in elements.tags if {"src", "href", "srcset", "action"} & given.keys()]
    assert "@import" not in stop
    assert "url(" not in stop
    assert not re.search(r"fetch\(|XMLHttpRequest|import\(|https?:", OURS)
    assert "default-src 'none'" in stop


def test_published_files_of_the_plotting_package_are_in_the_page_unchanged_with_their_licence(stop: str) -> None:
    assert WEB.joinpath("uPlot.iife.min.js").read_text() in stop
    assert WEB.joinpath("uPlot.min.css").read_text() in stop
    assert "The MIT License" in stop
    assert "</script" not in WEB.joinpath("uPlot.iife.min.js").read_text()


def test_every_topic_of_the_bag_is_drawn_or_named(stop: str) -> None:
    data = shown(stop)
    run = read_run(BAGS / "abs_stop")
    assert {topic["name"] for topic in data["topics"]} == set(run.series)
    assert data["not_drawn"] == ["/front_left/friction_curve_debug", "/imu/data"]
    drawn = {line["label"] for line in data["lines"]}
    assert {"front_left, ω r", "car, estimated", "car, speed sensor", "car, true"} <= drawn
    not_in_bag = {"mu_proven", "mu_lower"}
    assert {panel["key"] for panel in data["panels"]} == {panel.key for panel in PANELS} - not_in_bag
    assert {(strip["panel"], strip["group"]) for strip in data["strips"]} >= {
        *(("sign", group) for group in ("estimated", "true")),
        *(("supervisor", group) for group in ("state", "law", "release", "command")),
        *(("validity", group) for group in ("slip", "friction_slope", "friction_curve", "abs_supervisor")),
    }


def test_grip_is_drawn_with_its_bounds(tmp_path: Path) -> None:
    options = ProcessOptions(("friction_grip",))
    process_bag(BAGS / "abs_stop", tmp_path / "bag", options, 1, lambda _: None)
    write_page(read_run(tmp_path / "bag"), tmp_path / "page.html", "stop")
    lines = [line for line in shown((tmp_path / "page.html").read_text())["lines"] if line["panel"] == "grip"]
    assert {line["label"] for line in lines} >= {"used", "proven within 100 m", "lower bound"}


def drive_east(status: float = 0.0) -> RecordedRun:
    """Drive of 10 s and 111 m along the equator to the east, with a fix a second."""
    time, fixed = np.arange(0.0, 10.0, 0.05), np.arange(0.0, 11.0)
    parts = {f"{part}.{name}": 0.1 * np.ones(200) for part in ("vehicle", "front", "rear") for name in ("mu_x",)}
    parts |= {f"vehicle.{name}": 0.1 * np.ones(200) for name in ("mu_used", "mu_used_stddev")}
    bounds = {"mu_proven": 0.01 * time, "mu_lower": 0.5 * np.ones(200), "mu_upper": np.full(200, np.nan)}
    fixes = {"latitude": 0.0 * fixed, "longitude": 1e-4 * fixed, "status.status": status * np.ones(11)}
    series = {"grip": Series(time, parts | bounds), "gnss/fix": Series(fixed, fixes)}
    return RecordedRun(("front_left",), 10**9, series, time)


def test_track_has_the_friction_of_each_place() -> None:
    data = page_data(drive_east(), "drive")
    assert {"mu_proven", "mu_lower"} <= {panel["key"] for panel in data["panels"]}
    track = data["track"]
    east = np.array(track["east"]["v"]) / track["east"]["unit"]
    assert east == pytest.approx(11.12 * np.arange(0.0, 10.0, 0.05), abs=0.06)
    assert np.array(track["mu_proven"]["v"]) / track["mu_proven"]["unit"] == pytest.approx(
        0.01 * east / 11.12, abs=2e-4
    )


def test_track_needs_a_fix() -> None:
    data = page_data(drive_east(status=-1.0), "drive")
    assert data["track"] is None
    assert sum("no sensor_msgs/NavSatFix" in text for text in data["absent"]) == 2


def test_lines_have_the_values_and_times_of_the_bag(stop: str) -> None:
    data, run = shown(stop), read_run(BAGS / "abs_stop")
    (line,) = (each for each in data["lines"] if each["panel"] == "slip" and each["kind"] == "truth")
    slip = run.series["truth/front_left/slip"]
    assert values(line) == pytest.approx(slip["slip"], abs=5.1e-5)
    times = np.cumsum(data["times"][line["t"]]) / 1e4
    assert times == pytest.approx(slip.time, abs=5.1e-5)


def test_every_number_of_the_bag_is_a_signal(stop: str) -> None:
    data, run = shown(stop), read_run(BAGS / "abs_stop")
    signals = {(signal["topic"], signal["field"]): signal for signal in data["signals"]}
    finite = {
        (topic, field)
        for topic, series in run.series.items()
        for field, values in series.columns.items()
        if field != WHY and np.any(np.isfinite(values))
    }
    assert signals.keys() == finite
    rate, true = signals["front_left/slip", "slip_rate"], run.series["front_left/slip"]["slip_rate"]
    largest = np.nanmax(np.abs(true))
    assert values(rate) == pytest.approx(true[np.isfinite(true)], abs=1e-4 * largest)


def test_friction_measured_over_slip_is_that_of_the_road() -> None:
    """Of a wheel by its forces, of its axle by the deceleration; where the slip is not known there is no point."""
    time, sampled = np.arange(0.0, 2.0, 0.05), np.arange(0.0, 2.0, 0.005)
    slip = np.where(sampled < 1.0, 0.1, np.nan)
    ones = np.ones(time.size)
    force = {"fx": -3000.0 * ones, "fz": 4000.0 * ones, "valid": ones}
    grip = {"front.mu_x": 0.7 * ones, "rear.mu_x": np.nan * ones}
    series = {
        "front_left/slip": Series(sampled, {"slip": slip, "valid": np.isfinite(slip) * 1.0}),
        "front_left/tyre_force": Series(time, force),
        "grip": Series(time, grip),
    }
    axle, tyre = points_of(RecordedRun(("front_left",), 0, series, sampled))
    assert tyre.mu == pytest.approx(np.where(time < 0.999, 0.75, np.nan), nan_ok=True)
    assert axle.mu == pytest.approx(0.7 * ones)
    assert axle.slip == pytest.approx(np.where(time < 0.999, 0.1, np.nan), nan_ok=True)


def test_braking_of_a_stop_is_a_row_with_its_numbers(stop: str) -> None:
    (row,) = shown(stop)["brakings"]
    assert row["from"] == pytest.approx(30.0, abs=0.3)
    assert row["to"] == pytest.approx(5.0, abs=0.5)
    assert (row["from"] - row["to"]) / (row["end"] - row["start"]) < row["deceleration"] < row["hardest"]
    assert row["slip"] == pytest.approx(
        np.max(read_run(BAGS / "abs_stop").series["truth/front_left/slip"]["slip"]), 0.1
    )
    (part,) = row["parts"]
    curve = read_run(BAGS / "abs_stop").series["front_left/friction_curve"]
    valid = np.flatnonzero((curve["valid"] > 0.0) & (curve.time < row["end"]))
    best = valid[np.argmin(curve["lambda_max_stddev"][valid])]
    for name, true in (("lambda_max", 0.17), ("mu_max", 1.17)):
        value, reach = part[name]
        assert value == pytest.approx(curve[name][best], abs=1e-4)
        assert reach == pytest.approx(1.96 * curve[f"{name}_stddev"][best], abs=1e-4)
        assert abs(value - true) < reach


@pytest.mark.parametrize("bag", ["dry", "tyre_dynamic_2_0_bar"])
def test_bag_without_estimates_is_processed_on_the_way(bag: str, tmp_path: Path) -> None:
    out = tmp_path / "page.html"
    assert main([str(BAGS / bag), "--out", str(out)]) == 0
    data = shown(out.read_text())
    assert any("process" in text for text, _ in data["facts"])
    held = {panel["key"] for panel in data["panels"]}
    missing = {panel.key for panel in PANELS} - held
    assert len(data["absent"]) == len(missing)
    assert ("slip" in held) is (bag == "dry")
    assert "fz" in held


def test_damage_is_said_on_the_page_and_by_the_exit_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "bag.mcap").write_bytes(next((BAGS / "abs_stop").glob("*.mcap")).read_bytes())
    out = tmp_path / "new" / "page.html"
    assert main([str(tmp_path / "bag"), "--out", str(out)]) == 1
    said = capsys.readouterr()
    assert "damaged: " in said.err
    assert "Brakings of" in said.out
    data = shown(out.read_text())
    assert any("metadata.yaml" in text for text in data["problems"])
    assert data["lines"]


def test_page_that_exists_is_not_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "page.html"
    out.write_text("mine")
    assert main([str(BAGS / "abs_stop"), "--out", str(out)]) == 2
    assert out.read_text() == "mine"
    assert capsys.readouterr().err == f"error: {out} exists\n"


def test_nothing_that_a_bag_names_becomes_part_of_the_page(tmp_path: Path) -> None:
    stamp = Header(frame_id=HOSTILE)
    stamp.stamp.sec = 1000
    messages: list[tuple[str, Any]] = [
        ("/front_left/slip", WheelSlip(header=stamp, wheel=HOSTILE, validity=Validity(reason=1, text=HOSTILE))),
        (f"/{HOSTILE}/friction_slope", FrictionSlope(header=stamp, wheel=HOSTILE, validity=Validity(text=HOSTILE))),
        (
            "/front_left/friction_curve",
            FrictionCurve(header=stamp, method=HOSTILE, validity=Validity(valid=True), theta_1=float("nan")),
        ),
    ]
    write_bag(tmp_path / "bag", messages, {"note": HOSTILE, HOSTILE: "a"})
    bag = tmp_path / "<b onload=alert(3)>&amp;"
    (tmp_path / "bag").rename(bag)
    out = tmp_path / "page.html"
    assert main([str(bag), "--out", str(out)]) == 0
    page = out.read_text()
    elements = Elements(page)
    assert len(elements.scripts) == 3
    assert not {"img", "b"} & {tag for tag, _ in elements.tags if tag in ("img", "b")}
    assert "onerror=alert(2)>" not in page
    data = shown(page)
    assert data["title"] == bag.name
    assert HOSTILE in data["wheels"]
    assert any(HOSTILE in reason for topic in data["topics"] for reason in topic["reasons"])
    assert ["note", HOSTILE] in data["facts"]


def test_text_of_a_bag_is_set_as_text_by_our_script() -> None:
    assert "textContent" in OURS
    assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(|new Function", OURS)


def test_colours_panels_and_places_that_data_and_script_name_exist(stop: str) -> None:
    style = WEB.joinpath("drive.css").read_text()
    tones = {meaning["tone"] for meaning in shown(stop)["meanings"]}
    assert {"good", "bad", "middle"} <= tones
    assert all(style.count(f"--{tone}:") == 2 for tone in tones), "one each for light and dark"
    places = {given["id"] for _, given in Elements(stop).tags if "id" in given}
    assert set(re.findall(r'find\("#(\w+)', OURS)) <= places
    of_strips = {panel.key for panel in PANELS if not panel.axis and panel.key not in ("curve", "own")}
    assert set(re.findall(r"(\w+): stripPanel", OURS)) == of_strips


def test_values_that_are_no_numbers_are_gaps_and_absurd_ones_too() -> None:
    time = np.arange(6) / 10.0
    slip = np.array([0.1, np.nan, np.inf, -np.inf, 1e300, 0.2])
    series = {
        "front_left/slip": Series(
            time, {"slip": slip, "valid": np.ones(6), "vehicle_speed": slip, "wheel_speed": slip, WHY: np.zeros(6)}
        )
    }
    data = shown(html_page(page_data(RecordedRun(("front_left",), 0, series, time), "odd")))
    (line,) = (each for each in data["lines"] if each["panel"] == "slip")
    assert line["v"] == [1000, None, None, None, None, 2000]


def test_gap_of_the_messages_breaks_lines_and_strips() -> None:
    time = np.concatenate([np.arange(100), np.arange(2000, 2100)]) / 100.0
    ones = np.ones(200)
    series = {
        "front_left/friction_slope": Series(time, {"sign": ones, "valid": ones, "delay": 0.0 * ones, WHY: 0.0 * ones})
    }
    velocity = {"vehicle_velocity": Series(time, {"twist.twist.linear.x": np.sin(time)})}
    data = page_data(RecordedRun(("front_left",), 0, {**series, **velocity}, time), "gap")
    (line,) = data["lines"]
    assert line["v"].count(None) == 1
    (strip,) = (each for each in data["strips"] if each["panel"] == "sign")
    assert [data["meanings"][c]["text"] if c is not None else None for c in strip["c"]] == [
        "stable side",
        None,
        "stable side",
    ]
    assert np.cumsum(data["times"][strip["t"]]) / 1e4 == pytest.approx([0.0, 0.99, 20.0, 20.99], abs=0.01)


def test_sign_is_drawn_at_its_own_time() -> None:
    """The sign turns in the message at 1 s, which states a delay of 0.1 s; before it had none to state."""
    time = np.arange(200) / 100.0
    valid, delay = np.where(time > 0.295, 1.0, 0.0), np.where(time > 0.295, 0.1, np.nan)
    columns = {"sign": np.where(time < 0.995, 1.0, -1.0), "valid": valid, "delay": delay, WHY: 1.0 - valid}
    run = RecordedRun(
        ("front_left",), 0, {"front_left/friction_slope": Series(time, columns, Counter(["young"]))}, time
    )
    data = page_data(run, "delay")
    (strip,) = (each for each in data["strips"] if each["panel"] == "sign")
    assert np.cumsum(data["times"][strip["t"]]) / 1e4 == pytest.approx([-0.1, 0.2, 0.9, 1.89], abs=1e-3)


def test_what_was_never_valid_has_no_section_and_its_reason_is_listed() -> None:
    """The truth alone fills no section that is about estimates."""
    time = np.arange(100) / 100.0
    truth = {name: np.full(100, 0.2) for name in ("theta_1", "theta_2", "theta_3", "lambda_max", "mu_max")}
    truth |= {f"{name}_stddev": np.full(100, np.nan) for name in ("lambda_max", "mu_max")}
    never = {"valid": np.zeros(100), WHY: np.ones(100)}
    why = Counter({"front_left: waiting for the wheel to pass the peak": 100})
    nothing = {"sign": np.zeros(100), "delay": np.full(100, np.nan), **never}
    series = {
        "front_left/friction_curve": Series(time, {**{name: np.full(100, np.nan) for name in truth}, **never}, why),
        "truth/front_left/friction_curve": Series(time, truth),
        "front_left/friction_slope": Series(time, nothing, why),
        "truth/front_left/friction_slope": Series(time, {"sign": np.ones(100)}),
    }
    data = page_data(RecordedRun(("front_left",), 0, series, time), "never")
    assert {panel["key"] for panel in data["panels"]} == {"validity", "own"}
    for title in ("Slip at the peak", "Friction at the peak", "Friction curve at", "Sign of the slope"):
        (text,) = (each for each in data["absent"] if each.startswith(title))
        assert "never valid: waiting for the wheel to pass the peak" in text


@pytest.mark.parametrize(
    ("start", "begin"), [(1000.0, "stamp 1000.000 s, no date"), (1.7e9, "2023-11-14 22:13:20 UTC")]
)
def test_synthetic_stamps_have_no_date(start: float, begin: str) -> None:
    velocity = {"vehicle_velocity": Series(np.arange(2.0), {"twist.twist.linear.x": np.ones(2)})}
    assert ["begin", begin] in page_data(RecordedRun((), int(start * 1e9), velocity, np.empty(0)), "date")["facts"]


def test_reasons_that_differ_in_numbers_only_are_one() -> None:
    series = {
        "front_left/slip": Series(
            np.arange(4.0),
            {
                "slip": np.ones(4),
                "valid": np.zeros(4),
                "vehicle_speed": np.ones(4),
                "wheel_speed": np.ones(4),
                WHY: np.array([1.0, 2.0, 1.0, 3.0]),
            },
            Counter({"front_left: speed 1.0 is low": 2, "front_left: speed 2.0 is low": 1, "front_left: no sensor": 1}),
        )
    }
    data = page_data(RecordedRun(("front_left",), 0, series, np.arange(4.0)), "reasons")
    texts = [meaning["text"] for meaning in data["meanings"] if meaning["group"] == "slip"]
    assert texts == ["speed 1.0 is low", "no sensor"]
    assert any("speed 1.0 is low" in text for text in data["absent"])


def test_message_without_a_stamp_does_not_stretch_the_page_over_decades(tmp_path: Path) -> None:
    messages: list[tuple[str, Any]] = []
    for k in range(200):
        speed = TwistWithCovarianceStamped(header=header_at(1_700_000_000_000_000_000 + k * 10_000_000, ""))
        speed.twist.twist.linear.x = 20.0
        messages.append(("/vehicle_velocity", speed))
    messages.append(("/front_left/tyre_force", TyreForce(wheel="front_left", validity=Validity(valid=True))))
    messages.append(("/wheel_states", JointState()))
    write_bag(tmp_path / "bag", messages, {})
    run = read_run(tmp_path / "bag")
    assert run.start == 1_700_000_000_000_000_000
    assert set(run.series) == {"vehicle_velocity"}
    assert len([text for text in run.problems if "without a stamp" in text]) == 2
    assert page_data(run, "unset")["span"] == [0.0, 1.99]


def hour(rate: float) -> RecordedRun:
    """An hour of a car with four wheels that brakes every minute: noise on everything, so that nothing is short."""
    random = np.random.default_rng(1)
    time = np.arange(0.0, 3600.0, 1.0 / rate)
    braking = time % 60.0 > 56.0
    speed = np.where(braking, 25.0 - 8.0 * np.minimum(time % 60.0 - 56.0, 3.0), 25.0)
    valid = (braking & (random.random(time.size) < 0.7)).astype(np.float64)
    why = np.where(valid > 0.0, 0.0, 1.0 + random.integers(0, 3, time.size))
    reasons = Counter({"filling the window": 1, "brake torque is low": 2, "sign is young": 3})

    def noisy(mean: float, deviation: float) -> np.ndarray:
        return random.normal(mean, deviation, time.size)

    def code(largest: int) -> np.ndarray:
        return np.where(braking, random.integers(0, largest + 1, time.size), 0.0)

    judged = {"valid": valid, WHY: why}
    shared = {
        "slip": {"slip": noisy(0.15, 0.02), "vehicle_speed": speed, "wheel_speed": 3.0 * speed, **judged},
        "friction_slope": {"sign": np.sign(noisy(0.0, 1.0)), "delay": np.full(time.size, 0.06), **judged},
        "abs_supervisor": {
            **{
                "state": code(3),
                "law": code(1),
                "release": code(3),
                "limit": code(0),
                "intervention": code(3),
                "demand_torque": noisy(3e3, 10.0),
            },
            **{"slip_set_point": noisy(0.16, 0.01), **judged},
        },
        "abs_supervisor_debug": {"torque_set_point": noisy(1500.0, 50.0)},
        "brake_command": {"command": code(3)},
        "brake_pressure": {"fluid_pressure": noisy(5e6, 1e5)},
        "tyre_force": {
            **{"fx": noisy(-3e3, 50.0), "fz": noisy(4e3, 50.0), "valid": np.ones(time.size)},
            **{"fx_stddev": noisy(100.0, 5.0), "fz_stddev": noisy(100.0, 5.0), WHY: 0.0 * why},
        },
    }
    series = {}
    for wheel in ("front_left", "front_right", "rear_left", "rear_right"):
        series.update({f"{wheel}/{topic}": Series(time, columns, reasons) for topic, columns in shared.items()})
        curve = {name: noisy(0.2, 0.01) for name in ("theta_1", "theta_2", "theta_3", "lambda_max", "mu_max")}
        curve |= {f"{name}_stddev": noisy(0.02, 0.001) for name in ("lambda_max", "mu_max")}
        series[f"{wheel}/friction_curve"] = Series(time, {**curve, **judged}, reasons)
        for topic in ("slip", "friction_slope", "tyre_force"):
            series[f"truth/{wheel}/{topic}"] = Series(time, shared[topic])
    series["vehicle_velocity"] = Series(time, {"twist.twist.linear.x": noisy(20.0, 0.1)})
    return RecordedRun(("front_left", "front_right", "rear_left", "rear_right"), 0, series, time)


def test_an_hour_of_four_wheels_is_a_page_below_20_megabytes() -> None:
    """At 20 Hz there are already more samples than points, so more samples do not make it larger."""
    run = hour(20.0)
    page = html_page(page_data(run, "hour"))
    data = shown(page)
    assert len(data["brakings"]) == 60
    assert 3e6 < len(page.encode()) < 20e6
    longest = max(len(line["v"]) for line in data["lines"])
    assert longest <= 20_000
    pressures = [line for line in data["lines"] if line["panel"] == "pressure"]
    true = 1e-6 * run.series["front_left/brake_pressure"]["fluid_pressure"]
    assert (min(values(pressures[0])), max(values(pressures[0]))) == pytest.approx((true.min(), true.max()), abs=1e-3)
