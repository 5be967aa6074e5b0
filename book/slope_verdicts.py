"""Verdicts on sections 8.2.1 to 8.2.3."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.rows import Row, as_text
from book.verdicts import Verdict, claim, close, not_public

_FIGURES = {"(8.4)": "Figure 8.2", "(8.5)": "Figure 8.3"}
_ROADS = {"high_grip": "high grip", "off_road": "low grip"}
_MEAN_TOLERANCE = 0.06
"""The mean of a handful of drives is known no better than this share."""
_FOUND = 95.0
"""Share of the runs [%] in which a sign must be found to count as found."""
_EARLY = """the chapter's mean lies {where} the peak; of the shipped detections {shipped} % are early, and the printed
equation comes to {printed} with {early} % of its detections early"""
_ALIKE = """shipped, both detect together, as the interval of (8.6) is left out. Printed, with the torque threshold at
the onset, they differ by their false alarms there: {slips} by (8.4), {etas} by (8.5)"""


def mean_slips(rows: Sequence[Row]) -> list[Verdict]:
    """Verdicts on the mean slips at detection, from the rows of the table."""
    found = [not_public("8.2.3", "Strong braking of a car on asphalt and on a loose road was measured", _NO_DRIVES)]
    printed = [name for name in rows[0] if name.startswith("printed") and not name.endswith("[%]")]
    for row in rows:
        nearest = min(printed, key=lambda name: abs(float(row[name]) - float(row["chapter"])))
        before = float(row["chapter"]) < float(row["lambda_max"])
        why = _EARLY.format(
            where="before" if before else "at",
            printed=f"{as_text(row[nearest])} ({nearest.removeprefix('printed: ')})",
            early=as_text(row[f"{nearest}: early [%]"]),
            shipped=as_text(row["shipped: early [%]"]),
        )
        what = f"Mean slip at detection by {row['equation']}, {_ROADS[row['road']]}"
        place = f"8.2.3, {_FIGURES[row['equation']]}"
        found.append(close(place, what, row["chapter"], row["shipped"], _MEAN_TOLERANCE, " ".join(why.split())))
    by = {(row["road"], row["equation"]): row for row in rows}
    differences = [by[road, "(8.4)"]["shipped"] - by[road, "(8.5)"]["shipped"] for road in _ROADS]
    early = "printed: 28 samples, T_b above 30 N m"
    slips, etas = (" and ".join(as_text(by[road, e][early]) for road in _ROADS) for e in ("(8.4)", "(8.5)"))
    found.append(
        claim(
            "8.2.3",
            "Without slip the detection comes at a smaller slip than with it, on both roads",
            all(difference > 0.0005 for difference in differences),
            "smaller by " + " and ".join(as_text(difference) for difference in differences),
            " ".join(_ALIKE.format(slips=slips, etas=etas).split()),
        )
    )
    return found


_NO_DRIVES = "the drives are not published; these are simulated stops with its lambda_max and its noise"


def detection(rows: Sequence[Row]) -> list[Verdict]:
    """Verdicts on accuracy and reliability, from the rows of the part `slope`."""
    corners = [row for row in rows if "missed_percent" in row]
    stops = [row for row in rows if str(row["surface"]).endswith("_stop") and row.get("passed") is not None]
    found = []
    for method, place, what in (
        ("slip", "8.2.3, Figure 8.2", "With slip the sign is found accurately on both roads"),
        ("no_slip", "8.2.3, Figure 8.3", "Without slip the sign is found reliably, too"),
    ):
        judged = [row for row in stops if row["method"] == method]
        latest = max(row["value"] for row in judged if row["quantity"] == "delay, p95 [ms]")
        ours = f"{sum(bool(row['passed']) for row in judged)} of {len(judged)} limits hold; 95 % within {latest:.0f} ms"
        short = [
            f"{row['quantity']} is {as_text(row['value'])}, limit {as_text(row['limit'])}"
            for row in judged
            if not row["passed"]
        ]
        found.append(claim(place, what, not short, ours, "; ".join(short)))
    worst = max(corners, key=lambda row: row["missed_percent"] + row["false_alarm_percent"])
    errors = worst["missed_percent"] + worst["false_alarm_percent"]
    found.append(
        claim(
            "8.2.1, after (8.4)",
            "One small negative threshold on H, not zero, fits all roads",
            errors <= 100.0 - _FOUND,
            f"one set on four roads: at most {as_text(errors)} % missed or false ({worst['surface']})",
            "too many are missed or false",
        )
    )
    regained = 100.0 - max(row["regained_missed_percent"] for row in corners)
    found.append(
        claim(
            "8.2.2, 8.2.3, Figure 8.4",
            "The sign's change is found in both directions, as the supervisor needs it",
            regained >= _FOUND,
            f"regained stability found in at least {as_text(regained)} % of the runs",
            "the return is missed too often",
        )
    )
    at_peak = max(abs(row["slip_error_percent"]) for row in corners)
    found.append(
        claim(
            "8.2, before 8.2.1",
            "The moment of the change also tells lambda_max",
            at_peak <= 15.0,
            f"mean slip at detection within {as_text(at_peak)} % of lambda_max on four roads",
            "the slip at the crossing is off by more than 15 %",
        )
    )
    return found + _disagreement(corners)


def _disagreement(corners: Sequence[Row]) -> list[Verdict]:
    found = []
    for column, place, what, why in (
        (
            "disagreement_onset_ms",
            "8.2.1, (8.6)",
            "In hard braking there is a time in which eta and the slip rate have different signs while the slip rises",
            "here the slip grows from the onset to the release without a pause, and eta is positive with it",
        ),
        (
            "disagreement_release_ms",
            "8.2.1, (8.6)",
            "In the release there is such a time as well",
            "the release is so fast that no sample lies between the two changes of sign",
        ),
    ):
        longest = max(row[column] for row in corners)
        found.append(claim(place, what, longest > 0.0, f"up to {as_text(longest)} ms in four stops", why))
    exact = max(row["exact_lost_ms"] - row["exact_filter_delay_ms"] for row in corners)
    found.append(
        claim(
            "8.2.1, (8.3) to (8.5)",
            "The sign of H with that of the slip rate, or of eta, is the sign of the slope",
            exact <= 5.0,
            f"without noise it changes at most {as_text(exact)} ms after the peak, beyond the delay of its filter",
            "it changes later than a sample",
        )
    )
    return found
