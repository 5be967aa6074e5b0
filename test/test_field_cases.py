"""Cases from the field, each a small input with a script that judges what the product makes of it."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
CASES = Path(os.environ.get("FRICTION_CASES", ROOT.parent / "shared" / "cases"))
SCRIPTS = sorted(CASES.glob("*/run.sh"))
NEEDS_TEST_MSGS = ("first_stamp_zero",)
"""Cases whose messages are of a package that is not part of this workspace."""


@pytest.mark.skipif(not SCRIPTS, reason=f"{CASES} is absent (set FRICTION_CASES)")
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.parent.name)
def test_a_case_is_right(script: Path) -> None:
    if script.parent.name in NEEDS_TEST_MSGS:
        pytest.importorskip("test_msgs", reason="the package test_msgs is not installed")
    environment = {**os.environ, "PROJECT": str(ROOT)}
    done = subprocess.run(
        ["bash", str(script)], env=environment, cwd=script.parent, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
