"""The page in a browser: clicks, wheel, drags, fingers, keys, saved files; `make browser` installs what this needs."""

from __future__ import annotations

import csv
import io
import json
import re
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
import pytest

from friction_bags.results.recorded_run import RecordedRun, Series
from friction_bags.results.run_reader import read_run
from friction_report.__main__ import main
from friction_report.page import write_page

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is absent: make browser")
BAGS = Path(__file__).parents[3] / "bags"
CHROMIUM = next(filter(None, map(which, ("chromium", "chromium-browser", "google-chrome"))), None)

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on the path: make browser")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as running:
        opened = running.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture(scope="module")
def stop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Page of a recorded stop with estimates and smart-tyre forces of the truth."""
    out = tmp_path_factory.mktemp("browser") / "page.html"
    assert main([str(BAGS / "abs_stop"), "--out", str(out)]) == 0
    return out


@pytest.fixture
def page(browser: Any, stop: Path) -> Iterator[Any]:
    """A page of 1400 pixels; an error of its code fails the test."""
    opened = browser.new_page(viewport={"width": 1400, "height": 900})
    errors: list[str] = []
    opened.on("pageerror", lambda error: errors.append(str(error)))
    opened.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    opened.on("request", lambda request: errors.append(request.url) if request.url.startswith("http") else None)
    opened.goto(stop.as_uri())
    yield opened
    opened.close()
    assert not errors


def area(page: Any, panel: str) -> dict[str, float]:
    """Return the place of a plot's axes on the screen, scrolled into view."""
    over = page.locator(f"#panel_{panel} .u-over")
    over.scroll_into_view_if_needed()
    box: dict[str, float] = over.bounding_box()
    return box


def shown(page: Any) -> list[float]:
    slider = page.locator("#pick input")
    return [float(slider.get_attribute(name)) for name in ("min", "max")]


def width(page: Any) -> float:
    start, end = shown(page)
    return end - start


def eventually(page: Any, holds: Callable[[], bool]) -> None:
    """Wait for what a wheel or a pause brings; the page forbids the evaluation that playwright waits with."""
    for _ in range(100):
        if holds():
            return
        page.wait_for_timeout(20)
    pytest.fail("it did not come about within 2 s")


def saved(page: Any, panel: str, kind: str) -> tuple[str, bytes]:
    with page.expect_download() as started:
        page.locator(f"#{panel} .tools button", has_text=kind).click()
    return started.value.suggested_filename, Path(started.value.path()).read_bytes()


def table(page: Any, panel: str) -> list[list[str]]:
    name, text = saved(page, f"panel_{panel}", "CSV")
    assert name == f"abs_stop_{panel}.csv"
    return list(csv.reader(io.StringIO(text.decode("utf-8-sig"))))


def drag(page: Any, start: tuple[float, float], end: tuple[float, float]) -> None:
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
    page.mouse.move(*end)
    page.mouse.up()


def test_click_on_a_braking_shows_it_in_every_plot(page: Any) -> None:
    (braking,) = json.loads(page.locator("#drive").text_content())["brakings"]
    for _ in range(3):
        page.locator("[data-zoom=in]").click()
    assert shown(page)[0] > braking["start"]
    assert shown(page)[1] < braking["end"]
    page.locator("tr.braking button").click()
    assert shown(page)[0] < braking["start"]
    assert shown(page)[1] >= braking["end"]
    rows = table(page, "speed")
    assert float(rows[1][0]) < braking["start"]
    assert float(rows[-1][0]) == pytest.approx(braking["end"], abs=0.05)
    assert page.locator("tr.braking button").get_attribute("aria-pressed") == "true"


def test_hover_reads_values_of_all_plots_at_one_time(page: Any) -> None:
    box = area(page, "speed")
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    start, end = shown(page)
    for panel in ("speed", "slip"):
        text = page.locator(f"#panel_{panel} .u-legend .u-value").first.text_content()
        assert float(text) == pytest.approx((start + end) / 2, abs=0.02)
    assert "–" not in page.locator("#panel_speed .u-legend .u-value").nth(1).text_content()


def test_drag_zooms_the_time_and_double_click_shows_all_of_it(page: Any) -> None:
    whole, box = shown(page), area(page, "slip")
    middle = box["y"] + box["height"] / 2
    drag(page, (box["x"] + 0.25 * box["width"], middle), (box["x"] + 0.5 * box["width"], middle))
    start, end = shown(page)
    span = whole[1] - whole[0]
    assert start == pytest.approx(whole[0] + 0.25 * span, abs=0.01 * span)
    assert end == pytest.approx(whole[0] + 0.5 * span, abs=0.01 * span)
    rows = table(page, "slip")
    assert start <= float(rows[1][0]) <= float(rows[-1][0]) <= end, "what is saved is what is shown"
    page.mouse.dblclick(box["x"] + 0.5 * box["width"], middle)
    assert shown(page) == whole


def test_wheel_zooms_with_ctrl_or_after_a_click_and_scrolls_otherwise(page: Any) -> None:
    whole, box = shown(page), area(page, "slip")
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    before = page.evaluate("scrollY")
    page.mouse.wheel(0, 40)
    eventually(page, lambda: page.evaluate("scrollY") > before)
    assert shown(page) == whole
    page.keyboard.down("Control")
    page.mouse.wheel(0, -500)
    page.keyboard.up("Control")
    eventually(page, lambda: width(page) < 0.51 * (whole[1] - whole[0]))
    box = area(page, "slip")
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    zoomed = shown(page)
    page.mouse.wheel(0, 2000)
    eventually(page, lambda: width(page) > 1.5 * (zoomed[1] - zoomed[0]))


def test_shift_drag_and_the_pan_button_pan(page: Any) -> None:
    page.locator("[data-zoom=in]").click()
    start, end = shown(page)
    box = area(page, "speed")
    here = (box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    there = (here[0] + 0.1 * box["width"], here[1])
    page.keyboard.down("Shift")
    drag(page, here, there)
    page.keyboard.up("Shift")
    moved = shown(page)
    assert moved[1] - moved[0] == pytest.approx(end - start, rel=1e-6)
    assert moved[0] == pytest.approx(start - 0.1 * (end - start), abs=0.01 * (end - start))
    page.locator("#drag").click()
    box = area(page, "speed")
    here = (box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    drag(page, here, (here[0] - 0.1 * box["width"], here[1]))
    assert shown(page)[0] == pytest.approx(start, abs=0.01 * (end - start))


def test_values_zoom_by_a_drag_the_buttons_and_back(page: Any) -> None:
    def picture() -> bytes:
        return saved(page, "panel_speed", "PNG")[1]

    whole, before, box = shown(page), picture(), area(page, "speed")
    x = box["x"] + 0.5 * box["width"]
    drag(page, (x, box["y"] + 0.2 * box["height"]), (x, box["y"] + 0.5 * box["height"]))
    assert shown(page) == whole, "the time stays"
    zoomed = picture()
    assert zoomed != before
    page.locator("#panel_speed .tools button", has_text="y auto").click()
    assert picture() == before
    page.locator("#panel_speed .tools button", has_text="y +").click()
    assert picture() not in (before, zoomed)


def test_saved_table_holds_the_numbers_of_the_bag(page: Any) -> None:
    rows = table(page, "lambda_max")
    assert rows[0] == [
        "time since the first sample [s]",
        *(f"front_left [-]{end}" for end in ("", ", lower 95 %", ", upper 95 %")),
        "front_left, true [-]",
    ]
    whole = [list(map(float, row)) for row in rows[1:] if all(row)]
    assert whole
    assert all(low < value < high for _, value, low, high, _ in whole)
    assert {true for *_, true in whole} == {0.17}
    strips = table(page, "sign")
    assert strips[0] == ["of", "wheel", "from [s]", "to [s]", "meaning"]
    assert {row[4] for row in strips[1:]} >= {"stable side", "beyond the peak"}
    name, brakings = saved(page, "brakings", "CSV")
    (braking,) = csv.DictReader(io.StringIO(brakings.decode("utf-8-sig")))
    assert name == "abs_stop_brakings.csv"
    curve = read_run(BAGS / "abs_stop").series["front_left/friction_curve"]
    known = (curve["valid"] > 0.0) & (curve.time < float(braking["end [s]"]))
    assert float(braking["λ_max [-]"]) == pytest.approx(curve["lambda_max"][known][-1], abs=1e-4)


def test_saved_picture_is_a_png_of_the_plot(page: Any) -> None:
    for panel in ("slip", "sign", "curve"):
        name, data = saved(page, f"panel_{panel}", "PNG")
        assert name == f"abs_stop_{panel}.png"
        assert data.startswith(b"\x89PNG\r\n\x1a\n")
        width, height = struct.unpack(">II", data[16:24])
        assert width > page.locator(f"#panel_{panel} canvas").bounding_box()["width"]
        assert height > page.locator(f"#panel_{panel} canvas").bounding_box()["height"]


def test_curve_over_slip_has_its_band_and_the_measured_friction(page: Any) -> None:
    rows = table(page, "curve")
    curve = next(i for i, text in enumerate(rows[0]) if text == "front_left [-]")
    fitted = [list(map(float, (row[0], *row[curve : curve + 3]))) for row in rows[1:] if row[curve]]
    assert len(fitted) == 201
    assert all(low <= mu <= high for _, mu, low, high in fitted)
    assert max(mu for _, mu, _, _ in fitted) == pytest.approx(1.17, abs=0.01)
    assert page.locator("#panel_curve .key").text_content().startswith("front_left: µ_max")


def test_signals_of_ones_choice_are_drawn_and_removed(page: Any) -> None:
    own = page.locator("#panel_own")
    own.locator("select").select_option(label="front_left/slip slip_rate")
    own.get_by_role("button", name="draw", exact=True).click()
    own.locator("select").select_option(label="truth/vehicle_velocity twist.twist.linear.x")
    own.get_by_role("button", name="draw", exact=True).click()
    rows = table(page, "own")
    assert rows[0][1:] == ["front_left/slip slip_rate", "truth/vehicle_velocity twist.twist.linear.x"]
    speeds = [float(row[2]) for row in rows[1:] if row[2]]
    assert max(speeds) == pytest.approx(30.0, abs=0.3)
    assert min(speeds) == pytest.approx(5.0, abs=0.5)
    own.get_by_role("button", name="remove front_left/slip slip_rate").click()
    assert table(page, "own")[0][1:] == ["truth/vehicle_velocity twist.twist.linear.x"]


def test_keyboard_alone_reaches_brakings_plots_tools_and_numbers(page: Any) -> None:
    def focused() -> str:
        text: str = page.evaluate(
            "document.activeElement.getAttribute('aria-label') ?? document.activeElement.textContent.trim()"
        )
        return text

    reached = []
    for _ in range(60):
        page.keyboard.press("Tab")
        reached.append(focused())
    for name in ("save the brakings as CSV", "whole drive", "drag pans", "plot: Slip of each wheel", "numbers"):
        assert name in reached
    page.locator("#panel_slip .plot").focus()
    picked = float(page.locator("#pick input").input_value())
    page.keyboard.press("ArrowRight")
    assert float(page.locator("#pick input").input_value()) > picked
    eventually(page, lambda: "front_left 0." in page.locator("#announce").text_content())
    whole = shown(page)
    page.keyboard.press("+")
    assert width(page) == pytest.approx(0.5 * (whole[1] - whole[0]), rel=0.01)
    page.keyboard.press("Home")
    assert shown(page) == whole
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("ArrowRight")
    assert focused() == "zoom the values out"


def test_numbers_of_a_plot_follow_the_picked_time_and_hide_a_line(page: Any) -> None:
    panel = page.locator("#panel_slip")
    panel.locator("summary").click()
    first = panel.locator(".numbers tbody tr").first
    before = first.locator("td").first.text_content()
    page.locator("#pick input").fill("0.3")
    assert first.locator("td").first.text_content() != before
    assert [cell for cell in table(page, "slip")[0] if cell == "front_left [-]"]
    first.locator("input").uncheck()
    assert not [cell for cell in table(page, "slip")[0] if cell == "front_left [-]"]


def test_phone_shows_the_main_columns_and_one_finger_pans(browser: Any, stop: Path) -> None:
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True)
    page = context.new_page()
    page.goto(stop.as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    for text in ("grip used", "µ_max", "λ_max", "valid"):
        box = page.locator("#brakings th", has_text=re.compile(f"^{text}")).bounding_box()
        assert box["x"] >= 0.0
        assert box["x"] + box["width"] <= 390.0
    page.locator("[data-zoom=in]").click()
    start, end = shown(page)
    box = area(page, "speed")
    touch = context.new_cdp_session(page)
    y = box["y"] + box["height"] / 2
    touch.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": box["x"] + 100, "y": y}]})
    for x in (110, 130, 150):
        touch.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": [{"x": box["x"] + x, "y": y}]})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    assert shown(page)[0] == pytest.approx(start - 50.0 / box["width"] * (end - start), rel=0.05)
    fingers = [{"x": box["x"] + 100, "y": y, "id": 0}, {"x": box["x"] + 150, "y": y, "id": 1}]
    touch.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": fingers})
    before = shown(page)
    for x in (170, 200):
        fingers[1]["x"] = box["x"] + x
        touch.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": fingers})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    assert width(page) == pytest.approx(0.5 * (before[1] - before[0]), rel=0.1)
    context.close()


def test_paper_has_every_plot_and_no_buttons(page: Any) -> None:
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.locator("nav").is_hidden()
    assert page.locator("#panel_slip .tools").is_hidden()
    for canvas in page.locator("canvas").all():
        assert canvas.bounding_box()["width"] <= 700.0
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.emulate_media(media="screen")
    assert page.locator("#panel_slip canvas").bounding_box()["width"] > 1000.0


def test_click_on_the_track_picks_the_time_at_which_the_car_was_there(browser: Any, tmp_path: Path) -> None:
    time, fixed = np.arange(0.0, 10.0, 0.05), np.arange(0.0, 11.0)
    names = [
        f"{part}.{name}" for part in ("vehicle", "front", "rear") for name in ("mu_x", "mu_used", "mu_used_stddev")
    ]
    grip = {name: 0.1 * np.ones(200) for name in (*names, "mu_proven", "mu_lower", "mu_upper")}
    fixes = {"latitude": 1e-4 * fixed, "longitude": 1e-4 * fixed, "status.status": 0.0 * fixed}
    run = RecordedRun((), 10**9, {"grip": Series(time, grip), "fix": Series(fixed, fixes)}, time)
    write_page(run, tmp_path / "page.html", "drive")
    page = browser.new_page(viewport={"width": 1400, "height": 900})
    page.goto((tmp_path / "page.html").as_uri())
    box = area(page, "mu_proven")
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    assert float(page.locator("#pick input").input_value()) == pytest.approx(5.0, abs=0.2)
    said = page.locator("#panel_mu_proven .readout")
    eventually(page, lambda: re.search(r"0\.100 at 5\d m east, 5\d m north", said.inner_text()) is not None)
    name, rows = saved(page, "panel_mu_lower", "CSV")
    assert name == "drive_mu_lower.csv"
    assert len(rows.splitlines()) == 201
    page.close()
