"""The compiled algorithms give what their Python sources give, to the last bit."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from compile import COMPILED

ROOT = Path(__file__).resolve().parents[1]
MODULES = [f"{package}.{name.replace('/', '.')}" for package, names in COMPILED.items() for name in names.split()]


@pytest.mark.parametrize("module", MODULES)
def test_listed_module_runs_compiled(module: str) -> None:
    assert str(import_module(module).__file__).endswith(".so"), "not compiled: make build"


@pytest.mark.parametrize("module", MODULES)
def test_numbers_of_compiled_modules_are_final_or_they_are_looked_up_at_every_use(module: str) -> None:
    source = ROOT / "src" / module.split(".")[0] / f"{module.replace('.', '/')}.py"
    assigned = [node for node in ast.parse(source.read_text(encoding="utf-8")).body if isinstance(node, ast.Assign)]
    assert [ast.unparse(node) for node in assigned if _is_number(node.value)] == []


@pytest.mark.parametrize("bag", ["abs_stop", "snow"])
@pytest.mark.parametrize("method", ["rls", "default"])
def test_bag_processed_by_compiled_modules_equals_one_processed_by_their_sources(
    bag: str, method: str, tmp_path: Path
) -> None:
    parameters = tmp_path / "parameters.yaml"
    parameters.write_text(f"/**/friction_curve_id:\n  ros__parameters:\n    method: {method}\n")
    sources = [str(package.parent) for package in sorted((ROOT / "src").glob("*/setup.py"))]
    made = []
    for name, path in (("compiled", []), ("sources", sources)):
        env = {**os.environ, "PYTHONPATH": os.pathsep.join([*path, os.environ.get("PYTHONPATH", "")])}
        command = [sys.executable, "-m", "friction_bags", "process", str(ROOT / "bags" / bag), "--jobs", "1"]
        command += ["--out", str(tmp_path / name / "bag"), "--params-file", str(parameters)]
        subprocess.run(command, check=True, env=env, capture_output=True)
        made.append((tmp_path / name / "bag" / "bag_0.mcap").read_bytes())
    assert made[0] == made[1]


def _is_number(value: ast.expr) -> bool:
    if isinstance(value, ast.UnaryOp):
        return _is_number(value.operand)
    if isinstance(value, ast.BinOp):
        return _is_number(value.left)
    return isinstance(value, ast.Constant) and isinstance(value.value, int | float)
