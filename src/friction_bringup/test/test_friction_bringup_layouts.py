"""The layouts of Foxglove and PlotJuggler name topics and fields that exist."""

from __future__ import annotations

import json
from operator import attrgetter
from pathlib import Path
from xml.etree import ElementTree

import pytest
from friction_msgs.msg import BrakeDemand
from geometry_msgs.msg import TwistWithCovarianceStamped

from friction_bringup.live_view import TOPICS

LAYOUTS = Path(__file__).resolve().parents[1] / "layouts"
TYPES: dict[str, type] = {
    "/vehicle_velocity": TwistWithCovarianceStamped,
    "/brake_demand": BrakeDemand,
    **{f"{truth}/front_left/{name}": kind for name, kind in TOPICS.items() for truth in ("", "/truth")},
}


def foxglove_paths() -> list[str]:
    panels = json.loads((LAYOUTS / "foxglove.json").read_text())["configById"].values()
    return [path["value"] for panel in panels for path in panel.get("paths", [])]


def plotjuggler_paths() -> list[str]:
    curves = ElementTree.parse(LAYOUTS / "plotjuggler.xml").iter("curve")
    names = [curve.attrib["name"] for curve in curves]
    found = []
    for name in names:
        topic = max((topic for topic in TYPES if name.startswith(f"{topic}/")), key=len)
        found.append(f"{topic}.{name.removeprefix(f'{topic}/').replace('/', '.')}")
    return found


@pytest.mark.parametrize("paths", [foxglove_paths(), plotjuggler_paths()], ids=["foxglove", "plotjuggler"])
def test_layout_names_numbers_that_the_messages_have(paths: list[str]) -> None:
    assert len(paths) > 15
    for path in paths:
        topic, _, field = path.partition(".")
        assert isinstance(attrgetter(field)(TYPES[topic]()), (bool, int, float)), path


def test_every_panel_of_the_foxglove_layout_is_placed_once() -> None:
    content = json.loads((LAYOUTS / "foxglove.json").read_text())

    def leaves(node: str | dict[str, object]) -> list[str]:
        if isinstance(node, str):
            return [node]
        return [leaf for side in ("first", "second") for leaf in leaves(node[side])]  # type: ignore[arg-type]

    assert sorted(leaves(content["layout"])) == sorted(content["configById"])
