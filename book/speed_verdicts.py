"""Verdicts on section 8.3.3: Tables 8.4 and 8.5, Figures 8.10 to 8.13."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.rows import Row, as_text
from book.verdicts import Spread, Verdict, claim, not_public, single_run

_ROADS = {"high_grip": "dry", "off_road": "off-road"}
_METHODS = {"rls": "RLS", "rml_ml": "RML+ML"}
_ALIKE = 1.5
"""Errors up to this many times others count as comparable."""

Key = tuple[str, str, str, str, str]
"""Road, method, start, speed, instant."""


def verdicts(rows: Sequence[Row], stops: Sequence[Row]) -> list[Verdict]:
    """From the rows of Tables 8.4 and 8.5 in simulation, and of the driver's stops."""
    by: dict[Key, Row] = {
        (row["case"].split(", ")[1], row["method"], row["start"], row["speed"], row["instant"]): row for row in rows
    }
    found = [
        not_public(
            "8.3.3, Figures 8.10 to 8.13",
            "Professional drivers' stops, which hardly go beyond the peak, on dry asphalt and off the road",
            "the drives are not published; lambda_max and the numbers of samples are taken from Tables 8.4 and 8.5",
        )
    ]
    found += [_errors(by, key) for key in _chapter_cases(by)]
    return [*found, *_conclusions(by), *_on_stops(stops)]


def _chapter_cases(by: dict[Key, Row]) -> list[tuple[str, str, str]]:
    """Roads, methods and speeds for which the chapter gives numbers."""
    ends = {key: row for key, row in by.items() if key[2] == "all" and key[4] == "end"}
    return [(road, method, speed) for (road, method, _, speed, _), row in ends.items() if row["chapter_percent"] < 0.0]


def _key(case: tuple[str, str, str], start: str, instant: str) -> Key:
    road, method, speed = case
    return road, method, start, speed, instant


def _errors(by: dict[Key, Row], case: tuple[str, str, str]) -> Verdict:
    road, method, speed = case

    def spreads(start: str) -> list[Spread]:
        rows = [by[_key(case, start, instant)] for instant in ("activation", "end")]
        return [Spread(row["p5_percent"], row["median_percent"], row["p95_percent"]) for row in rows]

    chapter = [float(by[_key(case, "all", instant)]["chapter_percent"]) for instant in ("activation", "end")]
    others = all(runs.low <= number <= runs.high for number, runs in zip(chapter, spreads("beyond"), strict=True))
    why = "fitted with the samples beyond lambda_init only, both lie among the runs" if others else _SINGLE
    place = "Table 8.4" if speed == "measured" else "Table 8.5"
    what = f"Error of lambda_max at activation; at the end: {_METHODS[method]}, {_ROADS[road]}, {speed} speed [%]"
    return single_run(place, what, chapter, spreads("all"), why)


_SINGLE = "it is one drive of a real car; neither reading of lambda_init gives it on one corner in simulation"


def _conclusions(by: dict[Key, Row]) -> list[Verdict]:
    def rmse(road: str, method: str, start: str, speed: str = "measured", instant: str = "end") -> float:
        return float(by[road, method, start, speed, instant]["rmse_percent"])

    dry = [rmse("high_grip", method, "all") for method in ("rls", "rml_ml")]
    off = {start: [rmse("off_road", method, start) for method in ("rls", "rml_ml")] for start in ("all", "beyond")}
    at = [rmse("off_road", method, "beyond", instant="activation") for method in ("rls", "rml_ml")]
    over = {
        method: max(
            float(by[road, method, "all", "estimated", instant]["over_measured"])
            for road in _ROADS
            for instant in ("activation", "end")
        )
        for method in ("rls", "rml_ml")
    }
    found = [
        claim(
            "8.3.3.1, Table 8.4",
            "On dry asphalt RLS and RML+ML are comparable",
            max(dry) <= _ALIKE * min(dry),
            f"RMSE at the end {as_text(dry[0])} % and {as_text(dry[1])} %",
            "one has more than one and a half times the error of the other",
        ),
        claim(
            "8.3.3.1, Table 8.4",
            "With few samples, off the road, RML+ML depends on its start, and RLS is better",
            off["all"][1] > off["all"][0],
            f"RMSE at the end: RLS {as_text(off['all'][0])} %, RML+ML {as_text(off['all'][1])} %",
            "our fits begin at lambda_init with all samples of the braking; see the next line",
        ),
        claim(
            "8.3.3.1, Table 8.4",
            "The same where only samples beyond lambda_init are fitted",
            off["beyond"][1] > off["beyond"][0] and at[1] > at[0],
            f"RMSE at activation and end: RLS {as_text(at[0])}, {as_text(off['beyond'][0])} %, "
            f"RML+ML {as_text(at[1])}, {as_text(off['beyond'][1])} %",
            "RML+ML is not worse there",
        ),
    ]
    for method, place in (("rls", "8.3.3.2, Table 8.5"), ("rml_ml", "8.3.3.2")):
        found.append(
            claim(
                place,
                f"With estimated speed {_METHODS[method]} is as good as with measured speed",
                over[method] <= _ALIKE,
                f"RMSE at most {as_text(over[method])} times that with measured speed",
                "the error of the estimated speed adds to it",
            )
        )
    return found


def _on_stops(stops: Sequence[Row]) -> list[Verdict]:
    by = {(row["stop"], row["method"], row["speed"]): row for row in stops}
    at, failures = "median |error| at activation [%]", "failures at activation"
    measured, estimated = (by["high grip", "rls", speed] for speed in ("measured", "estimated"))
    return [
        claim(
            "8.3.3.1, Figure 8.10",
            "lambda_max is known to a few per cent when the ABS would act, also on a real car (RLS, dry)",
            measured[at] <= 5.0 and not measured[failures],
            f"on a car whose load moves and whose tyres relax: {as_text(measured[at])} %",
            "friction follows the slip late and the load swings: the samples are not those of the static curve",
        ),
        claim(
            "8.3.3.2, Figure 8.12",
            "The same with estimated speed",
            estimated[at] <= 5.0 and not estimated[failures],
            f"{as_text(estimated[at])} %, {estimated[failures]} of {estimated['runs']} without a peak within 50 %",
            "the speed without a sensor is off by a few 0.1 m/s in the stop, which is a tenth of lambda_max",
        ),
    ]
