"""Two built checkouts compared: the estimates of each over every bag, message by message and field by field.

The bags are those of the second checkout. Messages are paired by topic, stamp and order. Floats may differ by 1e-9,
relative above 1 and absolute below; NaN equals NaN. Integers, states, booleans and the sets of topics and messages must
be the same. Texts that differ, and fields that only one definition has, are listed but do not count. The supervisor
commands in both unless a parameter file changes that, so that commands are compared too. The topic "none" stands
for a bag without estimates from either checkout.

The exit code is 1 where something differs, as of every part, and 2 where a checkout could not process a bag.
"""

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.progress import Progress

from benchmarks.checkouts.bag_differences import TopicDifference, bag_differences
from benchmarks.checkouts.checkout import Checkout, CheckoutError
from benchmarks.rows import Row
from friction_parameters.parameter import ParameterError

_COMMANDING = "/**/abs_supervisor:\n  ros__parameters:\n    shadow: false\n"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this part."""
    parser.add_argument("--before", type=Path, required=True, help="a checkout, built")
    parser.add_argument("--after", type=Path, required=True, help="the other checkout, built")
    parser.add_argument("--bags", type=Path, help="directory of bags (default: bags of the checkout --after)")
    parser.add_argument(
        "--params-file", type=Path, action="append", default=[], help="ROS parameter file for both; repeatable"
    )


def run(options: argparse.Namespace) -> list[Row]:
    """Process every bag in both checkouts; return a row a bag and kind of topic.

    Raises:
        ParameterError: there are no bags, or a checkout could not process one.
    """
    bags = bags_of(options.bags or options.after / "bags")
    rows: list[Row] = []
    try:
        with Progress() as progress, TemporaryDirectory(prefix="friction_checkouts_") as name:
            commanding = Path(name, "parameters.yaml")
            commanding.write_text(_COMMANDING)
            task = progress.add_task("checkouts", total=2 * len(bags))
            for bag in bags:
                progress.update(task, description=bag.name)
                outs = []
                for side, root in (("before", options.before), ("after", options.after)):
                    out = Path(name, f"{bag.name}_{side}")
                    Checkout(root).process(bag, out, [commanding, *options.params_file])
                    outs.append(out)
                    progress.advance(task)
                found = bag_differences(*outs) or {"none": TopicDifference()}
                rows += [{"bag": bag.name, "topic": kind} | each.row() for kind, each in sorted(found.items())]
    except CheckoutError as error:
        raise ParameterError(str(error)) from error
    return rows


def bags_of(directory: Path) -> list[Path]:
    """Bags in a directory, by name.

    Raises:
        ParameterError: there are none.
    """
    found = sorted(path.parent for path in directory.glob("*/metadata.yaml"))
    if not found:
        raise ParameterError(f"{directory} holds no bags")
    return found
