"""`reindex`: repair of a bag whose recorder was killed; closes its files and rebuilds metadata.yaml."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from tempfile import TemporaryDirectory

from friction_bags.bag_io.bag_format import BagError, Contents, Topic, read_custom_data, write_metadata
from friction_bags.bag_io.bag_reader import BagReader, storage_files, storage_of
from friction_bags.bag_io.bag_writer import BagWriter


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
    count, problems = reindex(args.bag)
    for problem in problems:
        print(f"repaired: {problem}")
    print(f"{args.bag}: {count} messages; metadata.yaml written")
    return 0


def reindex(bag: Path) -> tuple[int, list[str]]:
    """Rebuild metadata.yaml from the files of a bag; a damaged mcap file is replaced by one of its sound messages.

    Returns:
        Number of messages, and what was wrong.

    Raises:
        BagError: the path is not a directory, holds no storage file or files of two kinds, or nothing can be read.
    """
    if not bag.is_dir():
        raise BagError(f"{bag} is not a directory: give the directory that holds the .mcap or .db3 files")
    files = [file for file in storage_files(bag) if file.suffix != ".zstd"]
    storages = {storage_of(file) for file in files}
    if len(storages) != 1:
        raise BagError(f"{bag} holds {'both .mcap and' if storages else 'neither .mcap nor'} .db3 files")
    contents: list[Contents] = []
    problems: list[str] = []
    for file in files:
        try:
            found, said = _repaired(file)
        except BagError as error:
            problems.append(f"{error}: left out")
            continue
        contents.append(found)
        problems.extend(said)
    if not contents:
        raise BagError(f"{bag}: nothing can be read: {'; '.join(problems)}")
    write_metadata(bag, storages.pop(), contents, read_custom_data(bag))
    return sum(each.message_count for each in contents), problems


def _repaired(file: Path) -> tuple[Contents, list[str]]:
    """Replace a damaged mcap file by one of its sound messages; return what it holds, and what was wrong."""
    counts: dict[Topic, int] = {}
    stamps: list[int] = []
    with BagReader(file) as reader:
        for topic, stamp, _ in reader.messages():
            counts[topic] = counts.get(topic, 0) + 1
            stamps = [min(stamp, *stamps), max(stamp, *stamps)] if stamps else [stamp, stamp]
        problems = list(reader.problems)
        contents = Contents(file.name, {**dict.fromkeys(reader.counts, 0), **counts}, *(stamps or (0, 0)))
        if problems and file.suffix == ".mcap":
            with TemporaryDirectory(dir=file.parent, prefix=".reindex_") as directory:
                with BagWriter(Path(directory, "bag")) as writer:
                    channels = {topic: writer.add_topic(topic) for topic in contents.counts}
                    for topic, stamp, data in reader.messages():
                        writer.write(channels[topic], stamp, data)
                Path(directory, "bag", "bag_0.mcap").replace(file)
    return contents, problems
