"""A bag of what a signal map makes of another bag."""

from collections.abc import Callable, Mapping
from pathlib import Path

from friction_bags.bag_io.bag_writer import BagWriter
from friction_bags.bag_vehicle import VEHICLE_NOTE
from friction_bags.mapped.mapped_bag import MappedBag

_SHOW_EVERY = 1000


def write_mapped(
    bag: MappedBag, out: Path, notes: Mapping[str, str], progress: Callable[[float], None] = lambda _: None
) -> int:
    """Write what the map makes, recorded with the messages that completed it; return the number of messages.

    Args:
        bag: the bag.
        out: bag to write.
        notes: notes of the new bag, in addition to its car.
        progress: called with the share that is done, 0 to 1.

    Raises:
        BagError: the new bag cannot be made.
    """
    duration = max(bag.end - bag.start, 1)
    count = 0
    with BagWriter(out, custom_data={**notes, VEHICLE_NOTE: bag.custom_data[VEHICLE_NOTE]}) as writer:
        channels = {topic: writer.add_topic(topic) for topic in bag.made}
        for topic, stamp, data in bag.messages(bag.made):
            writer.write(channels[topic], stamp, data)
            count += 1
            if count % _SHOW_EVERY == 0:
                progress((stamp - bag.start) / duration)
    return count
