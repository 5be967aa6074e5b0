"""Verdicts on sections 8.4.3 to 8.4.5."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.rows import Row, as_text
from benchmarks.smart_tyre.runs import STEADY
from book.smart_tyre_figures import CASE
from book.verdicts import Verdict, claim, close, not_public

_NO_SHIFT = 0.15
"""Shift that counts as none [deg]: one map for both axles leaves half the difference of their steady forces."""
_ENCODER_ACCURACY = 0.1
"""Angular resolution that the chapter gives [deg]."""
_OMEGA_0_TIME = 10.0
"""Constant speed that the chapter takes for Omega_0 [ms]."""


class Shown:
    """What the figures show, by axle and quantity."""

    def __init__(self, rows: Sequence[Row]) -> None:
        """Take the rows of the part `smart_tyre`."""
        self._values = {(str(r["axle"]), str(r["quantity"])): float(r["value"]) for r in rows if r["case"] == CASE}
        self.angle = max(float(r["value"]) for r in rows if r["quantity"] == "angle RMS (deg)")

    def of(self, axle: str, quantity: str) -> float:
        """One value."""
        return self._values[axle, quantity]

    def patch(self, axle: str, signal: str, phase: str, stage: str = "corrected", pressure: str = "2.0 bar") -> float:
        """Mean shift or length in a phase [deg]."""
        return self._values[axle, f"{pressure}, {stage}: {signal}, {phase} [deg]"]

    def change(self, axle: str, phase: str, pressure: str = "2.0 bar") -> float:
        """Change of the length from low speed to a phase [deg]."""
        low, now = (self.patch(axle, "length", each, pressure=pressure) for each in ("low speed", phase))
        return now - low


def verdicts(rows: Sequence[Row]) -> list[Verdict]:
    """From the rows of the part `smart_tyre`, drawn with figures."""
    shown = Shown(rows)
    return [*_signal(shown), *_speed_trend(shown), *_phases(shown), *_pressure(shown)]


def _signal(shown: Shown) -> list[Verdict]:
    spikes = shown.of("front", "twin spikes a revolution")
    rise = shown.of("front", "rise of the level from 8 to 22 m/s over that of omega^2 R")
    turn = shown.of("front", "time of a revolution at 8 m/s [ms]")
    return [
        not_public(
            "8.4.2, Figures 8.14, 8.15",
            "A BMW with four encoders and an accelerometer glued into one tyre was driven on dry asphalt",
            "neither the recordings nor the forces are published; tyre and drive are simulated with a belt model",
        ),
        claim(
            "8.4.3, Figure 8.16",
            "The radial acceleration has one twin spike for each revolution",
            abs(spikes - 1.0) <= 0.05,
            f"{as_text(spikes)} a revolution",
            "spikes are missed, or there are others",
        ),
        claim(
            "8.4.3, Figure 8.16",
            "Between the spikes it is constant: the centripetal acceleration",
            abs(rise - 1.0) <= 0.05,
            f"from 8 to 22 m/s it rises by {as_text(rise)} times the rise of omega^2 R",
            "the level is another",
        ),
        claim(
            "8.4.4, Figure 8.18",
            "The interpolated encoder gives the angle to about 0.1 degree",
            shown.angle <= _ENCODER_ACCURACY,
            f"RMS error {as_text(shown.angle)} degree",
            "it is less accurate",
        ),
        claim(
            "8.4.4",
            "The first 10 ms at constant low speed set the zero of the shift, Omega_0",
            turn <= _OMEGA_0_TIME,
            f"one revolution at 8 m/s takes {as_text(turn)} ms",
            "no patch passes in so short a time; it is read as seconds",
        ),
    ]


def _speed_trend(shown: Shown) -> list[Verdict]:
    effects = []
    for name in ("shift", "length"):
        trend = abs(shown.of("both", f"trend of the {name}, 8 to 22 m/s [deg]"))
        force = abs(
            shown.patch("rear", name, "braking", "without speed trend")
            - shown.patch("rear", name, "low speed", "without speed trend")
        )
        effects.append((name, trend, force))
    before, after = (
        shown.patch("front", "shift", "acceleration", stage) for stage in ("without speed trend", "corrected")
    )
    steady = [shown.patch(axle, "shift", phase) for axle in ("front", "rear") for phase in STEADY]
    lengths = [shown.patch(axle, "length", phase) for axle in ("front", "rear") for phase in STEADY]
    return [
        claim(
            "8.4.4, Figure 8.20",
            "Shift and length depend on speed, so much that the effect of the forces is almost hidden",
            all(trend >= force for _, trend, force in effects),
            "; ".join(f"{n}: {as_text(t)} degrees by speed, {as_text(f)} by hard braking" for n, t, f in effects),
            "our belt stiffens little with speed and the braking is hard: the trend must go, but it hides nothing",
        ),
        claim(
            "8.4.4, Figures 8.21 to 8.23",
            "Without the trend the shift is zero at every constant speed",
            max(abs(value) for value in steady) <= _NO_SHIFT,
            f"at most {as_text(max(abs(value) for value in steady))} degree",
            "a speed dependence is left",
        ),
        close(
            "8.4.4, Figures 8.22, 8.23",
            "and the length is 25 degrees at every constant speed (the farthest)",
            25.0,
            max(lengths, key=lambda value: abs(value - 25.0)),
            0.02,
            "a speed dependence is left",
        ),
        claim(
            "8.4.4, Figure 8.23",
            "A front wheel shows a small shift in acceleration, though it drives nothing: cross-talk of the load",
            abs(before) > _NO_SHIFT,
            f"{as_text(before)} degree before the correction",
            "the belt model has less cross-talk",
        ),
        claim(
            "8.4.4, (8.19), Figure 8.24",
            "A share beta of the change of length takes it away",
            abs(after) <= _NO_SHIFT,
            f"{as_text(after)} degree left, beta {as_text(shown.of('both', 'beta'))}",
            "more than that is left",
        ),
    ]


def _phases(shown: Shown) -> list[Verdict]:
    found = []
    driven = shown.patch("rear", "shift", "acceleration")
    found.append(
        claim(
            "8.4.5, Figure 8.25",
            "In acceleration the driven rear wheel's patch shifts forward",
            driven > _NO_SHIFT,
            f"{as_text(driven)} degrees",
            "it does not",
        )
    )
    front, rear = (shown.change(axle, "acceleration") for axle in ("front", "rear"))
    found.append(
        claim(
            "8.4.5, Figures 8.25, 8.26",
            "In acceleration the front patch becomes shorter and the rear one longer",
            front < 0.0 < rear,
            f"{as_text(front)} and {as_text(rear)} degrees",
            "the load goes the other way",
        )
    )
    shifts = [shown.patch(axle, "shift", "braking") for axle in ("front", "rear")]
    found.append(
        claim(
            "8.4.5, Figures 8.25, 8.26",
            "In braking both patches shift back",
            max(shifts) < -_NO_SHIFT,
            f"{as_text(shifts[0])} (front) and {as_text(shifts[1])} degrees (rear)",
            "one does not",
        )
    )
    front, rear = (shown.change(axle, "braking") for axle in ("front", "rear"))
    found.append(
        claim(
            "8.4.5, Figures 8.25, 8.26",
            "In braking the front patch becomes longer and the rear one shorter",
            rear < 0.0 < front,
            f"{as_text(front)} and {as_text(rear)} degrees",
            "the load goes the other way",
        )
    )
    return found


def _pressure(shown: Shown) -> list[Verdict]:
    longer = [
        shown.patch(axle, "length", phase, pressure="1.6 bar") - shown.patch(axle, "length", phase)
        for axle in ("front", "rear")
        for phase in STEADY
    ]
    ratios = [
        shown.patch(axle, "shift", "braking", pressure="1.6 bar") / shown.patch(axle, "shift", "braking")
        for axle in ("front", "rear")
    ]
    signs = all(
        shown.change("front", phase, "1.6 bar") * shown.change("front", phase) > 0.0
        and shown.change("rear", phase, "1.6 bar") * shown.change("rear", phase) > 0.0
        for phase in ("acceleration", "braking")
    )
    return [
        claim(
            "8.4.5, Figures 8.27, 8.28",
            "At 1.6 bar, not calibrated anew, all of this still holds",
            signs and shown.patch("rear", "shift", "acceleration", pressure="1.6 bar") > _NO_SHIFT,
            "every change has the sign that it has at 2.0 bar",
            "a sign has changed",
        ),
        claim(
            "8.4.5, Figures 8.27, 8.28",
            "At 1.6 bar the patch is a little longer",
            all(0.0 < each < 3.0 for each in longer),
            f"by {as_text(min(longer))} to {as_text(max(longer))} degrees of 25",
            "it is not",
        ),
        claim(
            "8.4.5, Figures 8.27, 8.28",
            "and its shift is much the same",
            all(abs(ratio - 1.0) <= 0.1 for ratio in ratios),
            f"in braking {as_text(ratios[0])} and {as_text(ratios[1])} times that at 2.0 bar",
            "it differs by more than a tenth",
        ),
    ]
