"""Topics and contents of a rosbag2 bag, and its metadata.yaml."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from rosbags.interfaces import Qos
from rosbags.rosbag2.metadata import dump_qos_v9

from friction_parameters.command_line import UserError

METADATA_NAME = "metadata.yaml"
_METADATA_VERSION = 9
"""Version of rosbag2 in ROS 2 Jazzy."""


class BagError(UserError):
    """A bag cannot be read or written; the text names the bag, the reason and what to do."""


@dataclass(frozen=True)
class Topic:
    """A topic of a bag."""

    name: str
    type: str
    """Message type, e.g. sensor_msgs/msg/JointState."""
    definition: str = ""
    """Text of the message definition and of those it refers to; empty where unknown."""
    definition_encoding: str = ""
    """ros2msg or ros2idl; empty where the definition is unknown."""
    type_hash: str = ""
    """RIHS01 hash of the type; empty where unknown."""
    qos: tuple[Qos, ...] = ()
    """QoS offered by each publisher when it was recorded."""

    def __hash__(self) -> int:
        """Hash of the name alone: topics are looked up at every message, and seldom share a name."""
        return hash(self.name)


def full_type(name: str) -> str:
    """Return the name of a message type in three parts: some recorders write sensor_msgs/Imu."""
    package, _, kind = name.partition("/")
    return f"{package}/msg/{kind}" if kind and "/" not in kind else name


@dataclass(frozen=True)
class Contents:
    """Contents of one storage file."""

    file: str
    """Name of the file, relative to the bag."""
    counts: Mapping[Topic, int]
    """Messages of each topic."""
    start: int
    """Earliest recording stamp [ns]; 0 in an empty file."""
    end: int
    """Latest recording stamp [ns]; 0 in an empty file."""

    @property
    def message_count(self) -> int:
        """Messages of all topics."""
        return sum(self.counts.values())


def write_metadata(bag: Path, storage: str, contents: Sequence[Contents], custom_data: Mapping[str, str]) -> None:
    """Write metadata.yaml in one step, as rosbag2 of Jazzy does.

    Args:
        bag: directory of the bag.
        storage: mcap or sqlite3.
        contents: contents of each file, in their order.
        custom_data: notes that travel with the bag.
    """
    counts: dict[Topic, int] = {}
    for content in contents:
        for topic, count in content.counts.items():
            counts[topic] = counts.get(topic, 0) + count
    filled = [content for content in contents if content.message_count]
    start = min((content.start for content in filled), default=0)
    end = max((content.end for content in filled), default=0)
    information = {
        "version": _METADATA_VERSION,
        "storage_identifier": storage,
        **_times(start, end),
        "message_count": sum(counts.values()),
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.type,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": dump_qos_v9(list(topic.qos)),
                    "type_description_hash": topic.type_hash,
                },
                "message_count": count,
            }
            for topic, count in counts.items()
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [content.file for content in contents],
        "files": [
            {
                "path": content.file,
                **_times(content.start, content.end),
                "message_count": content.message_count,
            }
            for content in contents
        ],
        "custom_data": dict(custom_data) or None,
        "ros_distro": "jazzy",
    }
    new = bag / f"{METADATA_NAME}.new"
    text = yaml.safe_dump({"rosbag2_bagfile_information": information}, sort_keys=False, allow_unicode=True)
    new.write_text(text, encoding="utf-8")
    new.replace(bag / METADATA_NAME)


def read_custom_data(bag: Path) -> dict[str, str]:
    """Return the notes in the metadata.yaml of a bag; none where there is no such file or it cannot be read."""
    try:
        document: Any = yaml.safe_load((bag / METADATA_NAME).read_text(encoding="utf-8"))
        notes = document["rosbag2_bagfile_information"].get("custom_data") or {}
        return {str(key): str(value) for key, value in notes.items()}
    except (OSError, yaml.YAMLError, UnicodeDecodeError, KeyError, TypeError, AttributeError):
        return {}


def _times(start: int, end: int) -> dict[str, dict[str, int]]:
    return {
        "duration": {"nanoseconds": end - start},
        "starting_time": {"nanoseconds_since_epoch": start},
    }
