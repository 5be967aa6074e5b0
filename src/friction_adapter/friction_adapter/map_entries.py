"""Texts and numbers of a signal map."""

from friction_parameters.yaml_file import Entry, YamlEntries, plain


class MapEntries(YamlEntries):
    """Reads the entries of one map; errors name file and line."""

    def text(self, key: str, entry: Entry) -> str:
        """Return a text that is not empty."""
        if not (isinstance(entry.value, str) and entry.value):
            raise self.error(entry, f"'{key}' = {plain(entry.value)!r} must be a text")
        return entry.value

    def number(self, key: str, entry: Entry, least: float, most: float) -> float:
        """Return a number between two limits."""
        value = entry.value
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not least <= value <= most:
            raise self.error(entry, f"'{key}' = {plain(value)!r} must be a number from {least:g} to {most:g}")
        return float(value)
