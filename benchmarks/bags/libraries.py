"""CPU time of rosbags and the mcap package for what friction_bags does itself: decode, encode and write messages.

Why there is code of our own: friction_runtime/cdr_layout.py and friction_bags/bag_io/mcap_chunk.py.
"""

import time
from collections.abc import Collection
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from friction_bags.bag_io.bag_format import Topic
from friction_bags.bag_io.bag_reader import BagReader


def library_seconds(bag: Path, inputs: Collection[str], out: Path) -> float:
    """CPU seconds in which the libraries decode the inputs in a bag, encode the others and write all of them.

    Args:
        bag: made by offline processing.
        inputs: names of the topics that were copied from the bag before.
        out: mcap file to be made.
    """
    store: Any = get_typestore(Stores.EMPTY)
    channels: dict[Topic, int] = {}
    seconds = 0.0
    with BagReader(bag) as reader, out.open("xb") as file:
        writer = Writer(file, chunk_size=4 << 20, compression=CompressionType.ZSTD)
        writer.start(profile="ros2")
        for topic in reader.counts:
            store.register(get_types_from_msg(topic.definition, topic.type))
            schema = writer.register_schema(topic.type, topic.definition_encoding, topic.definition.encode())
            channels[topic] = writer.register_channel(topic.name, "cdr", schema)
        for topic, stamp, data in reader.messages():
            begun = time.process_time()
            message = store.deserialize_cdr(data, topic.type)
            if topic.name not in inputs:
                begun = time.process_time()
                data = store.serialize_cdr(message, topic.type)
            writer.add_message(channels[topic], stamp, bytes(data), stamp)
            seconds += time.process_time() - begun
        begun = time.process_time()
        writer.finish()
    return seconds + time.process_time() - begun
