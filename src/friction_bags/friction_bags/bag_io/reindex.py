"""Repair of a bag whose recorder was killed: closes its files and rebuilds metadata.yaml."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from rosbags.rosbag2 import Reader

from friction_bags.bag_io.bag_format import BagError, Contents, read_custom_data, write_metadata
from friction_bags.bag_io.bag_reader import open_salvage, scan, storage_files, storage_of
from friction_bags.bag_io.mcap_writer import McapWriter


def add_arguments(parser: ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("bag", type=Path, help="directory of a bag")


def run(args: Namespace) -> int:
    """Repair a bag and print what was wrong.

    Returns:
        Exit code: 0.

    Raises:
        BagError: nothing can be repaired.
        OSError: a file cannot be read or written.
    """
    contents, problems = reindex(args.bag)
    for problem in problems:
        print(f"repaired: {problem}")
    total = sum(content.message_count for content in contents)
    print(f"{args.bag}: {total} messages in {len(contents)} files; metadata.yaml written")
    return 0


def reindex(bag: Path) -> tuple[list[Contents], list[str]]:
    """Rebuild metadata.yaml from the files of a bag; a damaged mcap file is replaced by one of its sound messages.

    Args:
        bag: directory of the bag.

    Returns:
        New contents of each file, and what was wrong.

    Raises:
        BagError: the path is not a directory, holds no storage file or files of two kinds, or nothing can be read.
    """
    if not bag.is_dir():
        raise BagError(f"{bag} is not a directory: give the directory that holds the .mcap or .db3 files")
    files = [file for file in storage_files(bag) if file.suffix != ".zstd"]
    storages = {storage_of(file) for file in files}
    if len(storages) != 1:
        raise BagError(f"{bag} holds {'both .mcap and' if storages else 'neither .mcap nor'} .db3 files")
    problems: list[str] = []
    contents = []
    for file in files:
        try:
            if not _is_sound(file) and file.suffix == ".mcap":
                problems.extend(_rewrite(file))
            salvage = open_salvage(file)
            contents.append(scan(file.name, salvage))
            problems.extend(salvage.problems)
        except (BagError, OSError) as error:
            problems.append(f"{error}: left out")
    if not contents:
        raise BagError(f"{bag}: nothing can be read: {'; '.join(problems)}")
    write_metadata(bag, storages.pop(), contents, read_custom_data(bag))
    return contents, problems


def _is_sound(file: Path) -> bool:
    """Whether index and all data can be read."""
    try:
        with Reader(file) as reader:
            for _ in reader.messages():
                pass
    except Exception:  # rosbags passes on errors of every layer below it
        return False
    return True


def _rewrite(file: Path) -> list[str]:
    """Replace a damaged mcap file by one of its sound messages, in one step; return what was wrong."""
    salvage = open_salvage(file)
    new = file.with_name(f"{file.name}.new")
    new.unlink(missing_ok=True)
    writer = McapWriter(new)
    try:
        for topic, stamp, data in salvage.messages():
            writer.write(writer.add_topic(topic), stamp, data)
        for topic in salvage.topics:
            writer.add_topic(topic)
    finally:
        writer.finish()
    new.replace(file)
    return list(salvage.problems)
