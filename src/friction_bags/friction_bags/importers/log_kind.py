"""The kind of a log, by what its file begins with: names lie, and loggers let their users choose them."""

import re
from enum import Enum
from pathlib import Path
from typing import Final

from friction_bags.bag_io.bag_format import BagError
from friction_bags.importers.frame_text import BUSMASTER_BEGIN, GVRET_BEGIN, is_printed


class Kind(Enum):
    """How a log is read."""

    BAG = "bag of ROS 2"
    ROS_1 = "bag of ROS 1"
    CAN = "CAN log, through python-can"
    FRAME_TEXT = "CAN frames as text"
    MDF = "MDF log"
    PARQUET = "Parquet table"
    TABLE = "table"


CAN_SUFFIXES: Final = (".asc", ".blf", ".log", ".trc")
"""Of the logs that python-can knows by their suffix."""
_BAG_SUFFIXES: Final = (".mcap", ".db3", ".zstd")
_MAGIC: Final = (
    (b"\x89MCAP", Kind.BAG),
    (b"SQLite format 3\0", Kind.BAG),
    (b"#ROSBAG", Kind.ROS_1),
    (b"MDF ", Kind.MDF),
    (b"UnFinMF ", Kind.MDF),
    (b"LOGG", Kind.CAN),
    (b"PAR1", Kind.PARQUET),
)
_REFUSED: Final = (
    (b"PK\x03\x04", "a zip archive or a spreadsheet: unpack it, or save the sheet as CSV"),
    (b"\xd0\xcf\x11\xe0", "an old spreadsheet: save the sheet as CSV"),
    (b"\x1f\x8b", "compressed by gzip: unpack it with gunzip"),
    (b"\x89HDF", "an HDF5 file (also MATLAB 7.3): export its signals as CSV, Parquet or MDF"),
    (b"MATLAB 5.0", "a MATLAB file: export its signals as CSV or Parquet"),
    (b"ULog", "a PX4 log: ulog2csv makes tables of its topics"),
    (b"<ldData>", "a MoTeC log: export it as CSV"),
    (b"@\0\0\0", "a MoTeC log: export it as CSV"),
)
_CANDUMP: Final = re.compile(r"\s*\([\d.]+\)\s+\S+\s+[0-9A-Fa-f]+#")
_PYTHON_CAN_CSV: Final = "timestamp,arbitration_id,"
_ASC: Final = re.compile(r"date\s+\w+|base\s+(hex|dec)\s+timestamps", re.IGNORECASE)
_TRC: Final = ";$FILEVERSION="


def kind_of(path: Path) -> tuple[Kind, str]:
    """Return the kind of a log, and the suffix that python-can reads it by, empty for other kinds.

    Raises:
        BagError: it is of a kind that is not read; the text names it.
        OSError: there is no such file.
    """
    suffix = path.suffix.lower()
    if path.is_dir() or suffix == ".zstd":
        return Kind.BAG, ""
    with path.open("rb") as stream:
        head = stream.read(4096)
    for magic, kind in _MAGIC:
        if head.startswith(magic):
            return kind, ".blf" if kind is Kind.CAN else ""
    for magic, text in _REFUSED:
        if head.startswith(magic):
            raise BagError(f"{path} cannot be read: it is {text}")
    by_text = _text_kind(head.decode("utf-8-sig", errors="replace"))
    if by_text is not None:
        return by_text
    if suffix in CAN_SUFFIXES:
        return Kind.CAN, suffix
    known = dict.fromkeys(_BAG_SUFFIXES, Kind.BAG)
    known |= {".bag": Kind.ROS_1, ".mdf": Kind.MDF, ".mf4": Kind.MDF, ".parquet": Kind.PARQUET}
    return known.get(suffix, Kind.TABLE), ""


def _text_kind(head: str) -> tuple[Kind, str] | None:
    lines = [line for line in head.splitlines()[:20] if line.strip()]
    if not lines:
        return None
    if lines[0].startswith(BUSMASTER_BEGIN) or lines[0].lower().startswith(GVRET_BEGIN) or is_printed(lines[0]):
        return Kind.FRAME_TEXT, ""
    if lines[0].startswith(_PYTHON_CAN_CSV):
        return Kind.CAN, ".csv"
    if _CANDUMP.match(lines[0]):
        return Kind.CAN, ".log"
    if lines[0].startswith(_TRC):
        return Kind.CAN, ".trc"
    return (Kind.CAN, ".asc") if any(_ASC.match(line) for line in lines[:3]) else None
