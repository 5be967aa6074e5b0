"""Selection of topics for a command: names and patterns, in the namespace of its node."""

from argparse import ArgumentParser, Namespace
from collections.abc import Collection, Sequence
from fnmatch import fnmatchcase


class TopicSelection:
    """Topics named by patterns such as `wheel_states`, `*/slip` or `/truth/*`."""

    def __init__(self, include: Sequence[str] = (), exclude: Sequence[str] = (), namespace: str = "/") -> None:
        """Take patterns.

        Args:
            include: patterns of topics to select; none for all.
            exclude: patterns of topics to leave out.
            namespace: namespace of patterns without a leading slash.
        """
        self._include = [_absolute(pattern, namespace) for pattern in include]
        self._exclude = [_absolute(pattern, namespace) for pattern in exclude]

    def wants(self, name: str) -> bool:
        """Whether the absolute name is selected."""
        if any(fnmatchcase(name, pattern) for pattern in self._exclude):
            return False
        return not self._include or any(fnmatchcase(name, pattern) for pattern in self._include)

    def is_complete(self, names: Collection[str]) -> bool:
        """Whether every selected topic is among these absolute names; always False with a wildcard."""
        return bool(self._include) and set(self._include) <= set(names)


def add_selection_arguments(parser: ArgumentParser) -> None:
    """Add the options that select topics."""
    parser.add_argument("--topics", nargs="+", default=[], metavar="TOPIC", help="only these, such as '*/slip'")
    parser.add_argument("--exclude", nargs="+", default=[], metavar="TOPIC", help="not these")


def selection_of(args: Namespace, namespace: str = "/") -> TopicSelection:
    """Return the selection by the options."""
    return TopicSelection(args.topics, args.exclude, namespace)


def _absolute(pattern: str, namespace: str) -> str:
    return pattern if pattern.startswith("/") else f"{namespace.rstrip('/')}/{pattern}"
