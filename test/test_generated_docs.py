"""Generated files are up to date with the code: parameter files, tables of the READMEs, Figure 8.1."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest
from PIL import Image

import docs
from book import state_machine_figure
from friction_bringup import graph
from friction_parameters.parameter import declared
from friction_parameters.parameter_file import load


def test_generated_files_are_up_to_date() -> None:
    stale = [str(file) for file, text in docs.generated_texts() if not file.exists() or file.read_text() != text]
    assert not stale, "run `make docs`"


def test_every_node_package_is_listed_and_ships_no_parameter_file_of_its_own_beside() -> None:
    modules = docs.ROOT.glob("src/*/*/parameters.py")
    packages = {file.parent.name for file in modules if "SHIPPED" in file.read_text(encoding="utf-8")}
    assert packages == set(docs.NODES)
    written = {file for file, _ in docs.generated_texts() if file.suffix == ".yaml"}
    assert written == {file for node in docs.NODES for file in (docs.ROOT / "src" / node / "config").glob("*.yaml")}


@pytest.mark.parametrize("node", docs.NODES)
def test_a_node_has_as_many_parameters_as_a_user_sets(node: str) -> None:
    """The plant has those of a run, too."""
    shipped = import_module(f"{node}.parameters").SHIPPED[node].parameters
    assert len(declared(type(shipped))) <= (36 if node == graph.PLANT else 20)


@pytest.mark.parametrize("node", graph.NODES)
def test_shipped_files_give_what_they_were_made_from(node: str) -> None:
    shipped = import_module(f"{node}.parameters").SHIPPED
    assert next(iter(shipped)) == node
    for name, file in shipped.items():
        path = docs.ROOT / "src" / node / "config" / f"{name}.yaml"
        assert load(type(file.parameters), path, node) == file.parameters


def test_the_figure_shows_the_transitions_of_the_machine() -> None:
    shown = Image.open(docs.FIGURE).info["Description"]
    assert shown == state_machine_figure.description(state_machine_figure.find_transitions())


def test_only_what_stands_between_the_marks_is_replaced(tmp_path: Path) -> None:
    file = tmp_path / "README.md"
    file.write_text("above\n<!-- table -->\nold\n\nold\n<!-- /table -->\nbelow\n")
    assert docs.with_block(file, "table", "new\n") == "above\n<!-- table -->\n\nnew\n\n<!-- /table -->\nbelow\n"


@pytest.mark.parametrize(
    "text", ["", "<!-- /t -->\n<!-- t -->\n", "<!-- t -->\n<!-- t -->\n<!-- /t -->\n", "<!-- t -->\n"]
)
def test_a_file_without_both_marks_is_refused(text: str, tmp_path: Path) -> None:
    file = tmp_path / "README.md"
    file.write_text(text)
    with pytest.raises(ValueError, match=r"README.md: it must hold the lines"):
        docs.with_block(file, "t", "new\n")
