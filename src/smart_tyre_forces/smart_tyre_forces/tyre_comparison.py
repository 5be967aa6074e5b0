"""Comparison of tyres: one that differs from its calibration, or all, with four instrumented wheels."""

from smart_tyre_forces.tyre_gain import TyreGain

_NOTICED = 0.04
"""Relative change of length that is reported."""
_LEARNED = 0.03
"""Relative deviation of the length below which a tyre counts as known."""
_FOUR = 4


class TyreComparison:
    """Gains of all wheels of a car; for texts only, no estimate depends on it."""

    def __init__(self) -> None:
        """Start with no wheel."""
        self.gains: dict[str, TyreGain] = {}
        """What is known of each instrumented wheel, by its name."""

    def verdict(self, wheel: str) -> str:
        """Return the cause of a changed patch length, by those of the other wheels; empty if it is as calibrated."""
        known = {name: gain.length - 1.0 for name, gain in self.gains.items() if gain.length_stddev < _LEARNED}
        own = known.get(wheel, 0.0)
        if abs(own) < _NOTICED:
            return ""
        longer = f"contact patch {100.0 * own:+.0f} % against its static load"
        if len(known) < _FOUR:
            return f"{longer}: with {len(known)} wheels known a tyre cannot be distinguished from all, or from the load"
        alike = [name for name, other in known.items() if abs(other) >= _NOTICED and other * own > 0.0]
        if len(alike) == len(known):
            return f"{longer}, as all others: all tyres (temperature, wear, pressure), or the mass of the car"
        if len(alike) == 1:
            return f"{longer}, unlike the others: this tyre"
        return f"{longer}, as {', '.join(name for name in alike if name != wheel)}: these tyres, or the load"
