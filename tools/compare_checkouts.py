"""Compare the estimates of two built checkouts over the same bags, field by field.

Usage: tools/run.bash python3 tools/compare_checkouts.py BEFORE AFTER [BAG ...]   (bags: those of AFTER)
Fields that only one definition has are left out; NaN equals NaN. Exit code: 1 where anything differs.
"""

import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader


def fields(message: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield names and values of all fields of a message but its constants."""
    for name, value in vars(message).items():
        if hasattr(value, "__msgtype__"):
            yield from fields(value, f"{prefix}{name}.")
        elif not name.isupper():
            yield prefix + name, value


def processed(checkout: Path, bag: Path, out: Path) -> dict[tuple[str, int, int], dict[str, Any]]:
    """Process a bag with the code of a checkout; return the fields of its messages by topic, stamp and order."""
    command = ["python", "-m", "friction_bags", "process", str(bag), "--out", str(out), "--outputs-only"]
    outer = {"PATH": os.environ["PATH"], "HOME": str(out.parent)}  # no paths of another checkout
    subprocess.run(
        [checkout / "tools/run.bash", *command], env=outer, cwd=out.parent, check=True, stdout=subprocess.DEVNULL
    )
    found, seen = {}, Counter[tuple[str, int]]()
    with AnyReader([out]) as reader:
        for at, stamp, raw in reader.messages():
            seen[at.topic, stamp] += 1
            found[at.topic, stamp, seen[at.topic, stamp]] = dict(fields(reader.deserialize(raw, at.msgtype)))
    return found


def differences(before: Path, after: Path, bag: Path) -> Iterator[str]:
    """Yield a line for every topic and field that differs."""
    with tempfile.TemporaryDirectory() as made:
        old, new = processed(before, bag, Path(made, "before")), processed(after, bag, Path(made, "after"))
    counts = Counter(f"{key[0]}: only {'before' if key in old else 'after'}" for key in old.keys() ^ new.keys())
    for key in old.keys() & new.keys():
        for name in old[key].keys() & new[key].keys():
            one, other = (np.asarray(values[key][name]) for values in (old, new))
            counts[f"{key[0]} {name}: differs"] += not np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    yield from (f"{bag.name} {what} in {count} messages" for what, count in sorted(counts.items()) if count)


if __name__ == "__main__":
    before, after, *bags = (Path(name).resolve() for name in sys.argv[1:])
    lines = [line for bag in bags or sorted(after.glob("bags/*/")) for line in differences(before, after, bag)]
    print(*lines or ["no estimate differs"], sep="\n")
    sys.exit(bool(lines))
