"""Digest of code: the same for the same code, another for other code."""

from pathlib import Path

import pytest

from friction_runtime.source_digest import source_digest


def test_what_is_digested_counts(tmp_path: Path) -> None:
    file = tmp_path / "own.py"
    file.write_text("a = 1\n")
    first = source_digest(["vehicle_models"], ["numpy"], [file])
    assert source_digest(["vehicle_models"], ["numpy"], [file]) == first
    assert source_digest(["vehicle_models", "friction_parameters"], ["numpy"], [file]) != first
    assert source_digest(["vehicle_models"], ["numpy", "scipy"], [file]) != first
    file.write_text("a = 2\n")
    assert source_digest(["vehicle_models"], ["numpy"], [file]) != first


@pytest.mark.parametrize(("packages", "libraries"), [(["no_such_package"], []), ([], ["no-such-library"])])
def test_what_is_not_there_is_an_error(packages: list[str], libraries: list[str]) -> None:
    with pytest.raises(ModuleNotFoundError):
        source_digest(packages, libraries)
