"""A bag made from imported or simulated messages."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from rclpy.time import Time

from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_io.cdr import encode, installed_topic


def write_bag(bag: Path, messages: Iterable[tuple[str, Any]], notes: Mapping[str, str]) -> int:
    """Write topics and messages with a header to a bag, recorded at their stamps; return their number.

    Raises:
        BagError: the bag cannot be made.
    """
    channels: dict[str, int] = {}
    count = 0
    with BagWriter(bag, custom_data=notes) as writer:
        for name, message in messages:
            if name not in channels:
                channels[name] = writer.add_topic(installed_topic(name, type(message)))
            stamp = Time.from_msg(message.header.stamp).nanoseconds
            writer.write(channels[name], stamp, encode(message))
            count += 1
    return count
