"""`analyse`: a table of a stranger becomes a draft of a map, and with it a page."""

from pathlib import Path

import numpy as np
import pytest

from friction_bringup.__main__ import main


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Twenty seconds of ordinary driving at 100 Hz."""
    time = 0.01 * np.arange(2000)
    speed = 15.0 - 3.0 * np.cos(0.4 * time)
    wheels = np.repeat(speed[:, None] / 0.3 * 1.08, 4, axis=1)
    table = np.column_stack([time, wheels, 1.2 * np.sin(0.4 * time)])
    names = "time [s],Wheel FL [km/h],Wheel FR [km/h],Wheel RL [km/h],Wheel RR [km/h],Long Acc [m/s^2]"
    np.savetxt(tmp_path / "drive.csv", table, "%.6f", ",", header=names)
    monkeypatch.chdir(tmp_path)
    return tmp_path / "drive.csv"


def test_a_log_becomes_a_draft_and_with_it_a_page(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["analyse", str(log), "--vehicle", "compact_car"]) == 0
    said = capsys.readouterr().out
    assert "Wheel FL [km/h]" in said
    draft = log.with_name("drive_map.yaml")
    assert str(draft.name) in said
    assert main(["analyse", str(log), "--map", str(draft)]) in (0, 1)  # the doctor may say what it misses
    page = log.with_name("drive_analysis") / "page.html"
    assert "<html" in page.read_text()[:500]
    assert "has its inputs" in capsys.readouterr().out


def test_results_are_not_overwritten(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["analyse", str(log), "--vehicle", "compact_car"]) == 0
    assert main(["analyse", str(log), "--vehicle", "compact_car"]) == 2
    assert "drive_map.yaml exists" in capsys.readouterr().err
    log.with_name("drive_analysis").mkdir()
    assert main(["analyse", str(log), "--map", "drive_map.yaml"]) == 2
    assert "nothing is overwritten" in capsys.readouterr().err


def test_a_log_without_wheels_says_so(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log.write_text(log.read_text().replace("Wheel", "Door"))
    assert main(["analyse", str(log), "--vehicle", "compact_car"]) == 1
    assert "not found by name: wheel_speed" in capsys.readouterr().err
