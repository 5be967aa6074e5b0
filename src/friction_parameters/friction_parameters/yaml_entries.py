"""Entries of one YAML file; errors name file and line."""

from collections.abc import Collection, Mapping
from pathlib import Path

from friction_parameters.parameter import ParameterError
from friction_parameters.yaml_source import Entry


class YamlEntries:
    """Reads the entries of one file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def error(self, entry: Entry, text: str) -> ParameterError:
        """Return an error at an entry."""
        return ParameterError(f"{self.path}: line {entry.line}: {text}")

    def mapping(self, key: str, entry: Entry) -> dict[str, Entry]:
        """Return the entries of a mapping.

        Raises:
            ParameterError: it is none.
        """
        if not isinstance(entry.value, dict):
            raise self.error(entry, f"'{key}' must hold keys and values")
        return entry.value

    def known(self, entries: Mapping[str, Entry], known: Collection[str]) -> None:
        """Refuse a key that is unknown here.

        Raises:
            ParameterError: a key is unknown; the text names those that are known.
        """
        for key, entry in entries.items():
            if key not in known:
                raise self.error(entry, f"unknown key '{key}': known here are {', '.join(known)}")
