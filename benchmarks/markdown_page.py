"""Rows of a result as a page of Markdown: tables that are narrow enough to read, with units in the names."""

import re
from collections.abc import Iterator, Sequence

from benchmarks.rows import Row, as_text

_WIDEST = 8
"""Columns of a table; one that has more is turned on its side, where its rows are few enough."""
_LONGEST = 30
"""Rows of a table."""
_UNITS = {"ms": "ms", "s": "s", "seconds": "s", "m": "m", "mb": "MB", "pct": "%", "percent": "%"}
"""Units by their word in a column's name."""
_UNIT_OF = {
    "speed_rms": "m/s",
    "worst_run_speed_rms": "m/s",
    "sigma_at_onset": "m/s",
    "sigma_at_end": "m/s",
    "coverage_95": "%",
    "mu_max_coverage_95": "%",
}
"""Units of columns without such a word."""
_WORD = re.compile(r"(?:lambda|mu)_max|theta_\d|[^_]+")
_ABOVE = ("seeds", "runs")
"""Numbers that stand once above a table where all of its rows have the same, as texts do."""


def page(title: str, description: str, command: str, rows: Sequence[Row]) -> str:
    """Return the page.

    Args:
        title: its heading.
        description: one line below it.
        command: the command line that made the rows.
        rows: flat rows; those with the same columns share their tables.
    """
    alike: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        alike.setdefault(tuple(row), []).append(row)
    blocks = [f"# {title}", f"{description[:1].upper()}{description[1:]}.", f"    {command}"]
    blocks += [block for same in alike.values() for block in _blocks(same, 2)]
    return "\n\n".join(blocks) + "\n"


def _blocks(rows: Sequence[Row], level: int) -> Iterator[str]:
    """Tables of rows with the same columns, under headings of `level` where there are several."""
    common = [name for name in rows[0] if _is_common(name, rows)]
    if common:
        yield "; ".join(f"{label(name)}: {_cell(rows[0][name])}" for name in common)
    rest = [{name: value for name, value in row.items() if name not in common} for row in rows]
    keys = _keys(rest)
    wide = len(rest[0]) > _WIDEST
    if len(keys) > 1 and len(rest) > (_WIDEST if wide else _LONGEST):
        key = min(keys, key=lambda name: len({row[name] for row in rest}))
        for value in dict.fromkeys(row[key] for row in rest):
            yield f"{'#' * level} {label(key)}: {_cell(value)}"
            group = [row for row in rest if row[key] == value]
            yield from _blocks([{name: row[name] for name in row if name != key} for row in group], level + 1)
    elif wide:
        head = [", ".join(map(label, keys)), *(", ".join(_cell(row[key]) for key in keys) for row in rest)]
        turned = [name for name in rest[0] if name not in keys]
        yield _table(head, [[label(name), *(_cell(row[name]) for row in rest)] for name in turned], 1)
    else:
        yield _table(list(map(label, rest[0])), [list(map(_cell, row.values())) for row in rest], len(keys))


def _is_common(name: str, rows: Sequence[Row]) -> bool:
    may_stand_above = name in _ABOVE or (isinstance(rows[0][name], str) and rows[0][name] != "")
    return len(rows) > 1 and may_stand_above and all(row[name] == rows[0][name] for row in rows)


def _keys(rows: Sequence[Row]) -> list[str]:
    """The first columns, as many as it takes to distinguish all rows."""
    names = list(rows[0])
    for count in range(1, len(names)):
        if len({tuple(row[name] for name in names[:count]) for row in rows}) == len(rows):
            return names[:count]
    return names


def _cell(value: object) -> str:
    return as_text(value).replace("|", r"\|")


def _table(head: Sequence[str], lines: Sequence[Sequence[str]], left: int) -> str:
    """Return a table whose first `left` columns are aligned to the left and the others to the right."""
    rule = ["---" if column < left else "---:" for column in range(len(head))]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (head, rule, *lines))


def label(name: str) -> str:
    """Name of a column in words, with its unit behind: "delay_median_ms" is "delay median [ms]"."""
    words = _WORD.findall(name)
    unit = next((_UNITS[word] for word in words if word in _UNITS), _UNIT_OF.get(name))
    text = " ".join(word for word in words if word not in _UNITS) or "time"
    text = re.sub(r"(\d)pct\b", r"\1 %", text)
    return f"{text} [{unit}]" if unit else text
