"""The layouts of Foxglove and PlotJuggler name topics and fields that exist, for all four wheels, raw and valid."""

from __future__ import annotations

import json
import re
from operator import attrgetter
from pathlib import Path
from xml.etree import ElementTree

import pytest
from friction_msgs.msg import BrakeDemand, Grip
from geometry_msgs.msg import TwistWithCovarianceStamped

from friction_bringup.live_view import TOPICS
from friction_state.ros.processor import FORCE_MARKERS

LAYOUTS = Path(__file__).resolve().parents[1] / "layouts"
WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
TYPES: dict[str, type] = {
    "/vehicle_velocity": TwistWithCovarianceStamped,
    "/brake_demand": BrakeDemand,
    "/grip": Grip,
    **{
        f"{truth}/{wheel}/{name}": kind for wheel in WHEELS for name, kind in TOPICS.items() for truth in ("", "/truth")
    },
}
FILTER = re.compile(r"(?P<topic>[^{]+)\{(?P<flag>\S+)==true\}(?P<field>.+)")


def foxglove_paths() -> list[str]:
    """Topic and field of every curve, the flag of a filter too."""
    panels = json.loads((LAYOUTS / "foxglove.json").read_text())["configById"].values()
    found = []
    for value in (path["value"] for panel in panels for path in panel.get("paths", [])):
        valid = FILTER.fullmatch(value)
        found += [f"{valid['topic']}.{valid['flag']}", valid["topic"] + valid["field"]] if valid else [value]
    return found


def plotjuggler_paths() -> list[str]:
    """Topic and field of every curve; of one that shows valid values only, its two sources."""
    root = ElementTree.parse(LAYOUTS / "plotjuggler.xml")
    made = {
        snippet.attrib["name"]: [snippet.findtext("linked_source"), snippet.findtext("additional_sources/v1")]
        for snippet in root.iter("snippet")
    }
    found = []
    for name in (curve.attrib["name"] for curve in root.iter("curve")):
        for source in made.get(name, [name]):
            assert source is not None
            topic = max((topic for topic in TYPES if source.startswith(f"{topic}/")), key=len)
            found.append(f"{topic}.{source.removeprefix(f'{topic}/').replace('/', '.')}")
    return found


@pytest.mark.parametrize("paths", [foxglove_paths(), plotjuggler_paths()], ids=["foxglove", "plotjuggler"])
def test_layout_names_numbers_that_the_messages_have(paths: list[str]) -> None:
    assert len(paths) > 60
    for path in paths:
        topic, _, field = path.partition(".")
        assert isinstance(attrgetter(field)(TYPES[topic]()), (bool, int, float)), path


@pytest.mark.parametrize("paths", [foxglove_paths(), plotjuggler_paths()], ids=["foxglove", "plotjuggler"])
def test_layout_shows_every_wheel_raw_and_valid(paths: list[str]) -> None:
    for wheel in WHEELS:
        assert {f"/{wheel}/friction_curve.lambda_max", f"/{wheel}/friction_curve.validity.valid"} <= set(paths)


def test_foxglove_layout_shows_what_is_used_proven_and_left() -> None:
    assert {"/grip.vehicle.mu_used", "/grip.mu_proven", "/grip.mu_lower", "/grip.mu_upper"} <= set(foxglove_paths())


def test_foxglove_layout_shows_the_forces_as_arrows() -> None:
    panel = json.loads((LAYOUTS / "foxglove.json").read_text())["configById"]["3D!1"]
    assert panel["topics"] == {f"/{FORCE_MARKERS}": {"visible": True}}
    assert panel["followTf"] == panel["layers"]["road"]["frameId"] == "base_link"


def test_every_panel_of_the_foxglove_layout_is_placed_once() -> None:
    content = json.loads((LAYOUTS / "foxglove.json").read_text())

    def leaves(node: str | dict[str, object]) -> list[str]:
        if isinstance(node, str):
            tabs = content["configById"][node].get("tabs", [])
            return [node] + [leaf for tab in tabs for leaf in leaves(tab["layout"])]
        return [leaf for side in ("first", "second") for leaf in leaves(node[side])]  # type: ignore[arg-type]

    assert sorted(leaves(content["layout"])) == sorted(content["configById"])
