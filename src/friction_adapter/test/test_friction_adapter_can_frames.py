"""Without the packages for CAN everything else runs, and the line that installs them is named."""

import sys
from pathlib import Path

import pytest

from friction_adapter.sources import CanFrames
from friction_parameters.parameter import ParameterError

DBC = """VERSION ""
BU_: E
BO_ 1 A: 2 E
 SG_ Speed : 0|16@1+ (0.1,0) [0|100] "km/h" E
BO_ 2 B: 3 E
 SG_ Speed : 0|16@1+ (0.1,0) [0|100] "km/h" E
 SG_ Gear : 16|4@1+ (1,0) [0|7] "" E
"""


def frames(directory: Path, text: str = DBC) -> CanFrames:
    path = directory / "car.dbc"
    path.write_text(text)
    return CanFrames(path)


def test_without_the_packages_the_line_that_installs_them_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "cantools.database", None)
    with pytest.raises(ParameterError, match="python3 -m pip install python-can cantools"):
        frames(tmp_path)


class TestWithCantools:
    @pytest.fixture(autouse=True)
    def needs_cantools(self) -> None:
        pytest.importorskip("cantools", reason="cantools is absent: python3 -m pip install python-can cantools")

    def test_a_signal_is_found_by_its_name_or_that_of_its_frame(self, tmp_path: Path) -> None:
        assert frames(tmp_path).find("Gear") == ("B", "Gear", "")
        assert frames(tmp_path).find("A.Speed") == ("A", "Speed", "km/h")

    @pytest.mark.parametrize(
        ("name", "said"),
        [("Speed", "several CAN signals have the name 'Speed': A.Speed, B.Speed"), ("Speeed", "there are Speed")],
    )
    def test_a_name_of_none_or_several_is_refused(self, tmp_path: Path, name: str, said: str) -> None:
        with pytest.raises(ValueError, match=said):
            frames(tmp_path).find(name)

    def test_frames_that_are_not_kept_unknown_or_too_short_give_nothing(self, tmp_path: Path) -> None:
        bus = frames(tmp_path)
        bus.keep(["A"])
        (found,) = bus.decode(1, False, bytes([232, 3]))
        assert (found.name, dict(found.values)) == ("A", {"Speed": pytest.approx(100.0)})
        assert bus.decode(2, False, bytes(2)) == bus.decode(1, True, bytes(2)) == []
        assert bus.undecoded == 0
        assert bus.decode(1, False, bytes(1)) == []
        assert bus.undecoded == 1

    def test_a_short_frame_is_decoded_as_far_as_it_goes(self, tmp_path: Path) -> None:
        bus = frames(tmp_path)
        (found,) = bus.decode(2, False, bytes([232, 3]))
        assert dict(found.values) == {"Speed": pytest.approx(100.0)}

    def test_a_frame_that_has_not_come_is_named_with_the_nearest_that_has(self, tmp_path: Path) -> None:
        bus = frames(tmp_path)
        bus.keep(["A"])
        bus.decode(2, False, bytes(3))
        bus.decode(700, False, bytes(3))
        assert bus.not_in_log() == ["frame A (001) is not in the log; the nearest that is there is 002"]
        bus.decode(1, False, bytes(2))
        assert bus.not_in_log() == []

    def test_pages_of_a_frame_are_sources_of_their_own(self, tmp_path: Path) -> None:
        pages = """VERSION ""
BU_: E
BO_ 1 A: 3 E
 SG_ Page M : 0|8@1+ (1,0) [0|255] "" E
 SG_ Left m0 : 8|16@1+ (0.1,0) [0|100] "km/h" E
 SG_ Right m1 : 8|16@1+ (0.1,0) [0|100] "km/h" E
"""
        bus = frames(tmp_path, pages)
        sources = [bus.find(name)[0] for name in ("Page", "Left", "Right")]
        assert sources == ["A", "A page 0", "A page 1"]
        bus.keep(sources)
        assert [each.name for each in bus.decode(1, False, bytes([1, 232, 3]))] == ["A", "A page 1"]

    def test_a_file_that_contradicts_itself_elsewhere_is_read(self, tmp_path: Path) -> None:
        text = DBC + 'BO_ 3 C: 1 E\n SG_ Volume : 4|8@1+ (1,0) [0|1] "" E\n'
        bus = frames(tmp_path, text)
        assert "Volume" in bus.notes[0]
        bus.keep(["A", "B"])
        with pytest.raises(ParameterError, match="Volume"):
            bus.keep(["A", "C"])

    def test_a_file_that_is_no_dbc_file_is_refused(self, tmp_path: Path) -> None:
        with pytest.raises(ParameterError, match="cannot be read"):
            frames(tmp_path, "BO_ nonsense {")
        with pytest.raises(ParameterError, match="No such file"):
            CanFrames(tmp_path / "none.dbc")
