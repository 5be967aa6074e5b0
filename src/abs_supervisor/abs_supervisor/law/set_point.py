"""The slip that the law holds."""

from typing import Final

from abs_supervisor.law.road_curve import RoadCurve

_TO_PASS: Final = 1.10
"""Of lambda_max while the peak has not been seen: it is passed, and so seen."""
_HELD: Final = 0.92
"""Of lambda_max afterwards: friction is flat there, and the wheel is stable."""
_SLOW: Final = 8.0
"""[m/s] below this speed the wheel is quick, and a smaller slip keeps it from the lock."""
_AT_REST: Final = 0.70
"""Share at standstill."""


def slip_set_point(curve: RoadCurve, seen: bool, speed: float) -> float:
    """Return the slip [-] to hold on a road at a speed of the car [m/s]; `seen`: its peak has been passed."""
    share = _HELD if seen else _TO_PASS
    if speed < _SLOW:
        share = min(share, _AT_REST + (_HELD - _AT_REST) * max(speed, 0.0) / _SLOW)
    return share * curve.lambda_max
