"""Roads by weather: what friction they have while a region is dry or wet, and what a change of the weather does.

Of all roads a share b is bare, the others are under snow or ice. In weather w, dry or wet, a bare road is as the
weather is with probability q, else as bare roads are on average:

    p(x | w) = b p_b(x | w) + (1 - b) p_s(x),    p_b(x | w) = q p_w(x) + (1 - q) sum_v P(v) p_v(x)

A change of the weather draws every bare road anew from p_b(x | w) and leaves snow and ice as they are.
"""

import numpy as np
from numpy.typing import NDArray

from friction_grip.road_prior import RoadPrior

Array = NDArray[np.float64]

_AS_WEATHER = 0.8
"""Share of bare roads that are as the weather is; the others have been dried by sun and cars, or stay wet after it."""
_SHARES = RoadPrior()
_BARE = (_SHARES.dry + _SHARES.wet) / (_SHARES.dry + _SHARES.wet + _SHARES.snow + _SHARES.ice)
WEATHERS: Array = np.array([_SHARES.dry, _SHARES.wet]) / (_SHARES.dry + _SHARES.wet)
"""Probability of dry and of wet weather, before anything is known, (2,)."""


def _bare_roads(is_wet: bool) -> Array:
    wet = _AS_WEATHER * is_wet + (1.0 - _AS_WEATHER) * float(WEATHERS[1])
    return RoadPrior(dry=1.0 - wet, wet=wet, snow=0.0, ice=0.0).density()


_BARE_ROADS: Array = np.array([_bare_roads(False), _bare_roads(True)])
_SNOW_AND_ICE = RoadPrior(dry=0.0, wet=0.0, snow=_SHARES.snow, ice=_SHARES.ice).density()
ROADS: Array = _BARE * _BARE_ROADS + (1.0 - _BARE) * _SNOW_AND_ICE
"""Probability of each friction of GRID in dry and in wet weather, (2, 90)."""
_IS_BARE = _BARE * (WEATHERS @ _BARE_ROADS) / (WEATHERS @ ROADS)
KINDS: Array = np.array([_IS_BARE, 1.0 - _IS_BARE])
"""Probability that a road of each friction is bare, and that it is under snow or ice, (2, 90)."""


def weather_later(chances: Array, unchanged: float) -> Array:
    """Return the probability of dry and wet weather after a time, (2,).

    Args:
        chances: before it, (2,).
        unchanged: probability that the weather has not been drawn anew.
    """
    return np.asarray(unchanged * chances + (1.0 - unchanged) * WEATHERS)


def roads_later(densities: Array, unchanged: float) -> Array:
    """Return the probability of weather and friction of a road after a time, (2, 90).

    Args:
        densities: before it, (2, 90); they sum up to one.
        unchanged: probability that the weather has not been drawn anew, and likewise the road.
    """
    drawn = (1.0 - unchanged) * WEATHERS[:, None]
    turned = drawn * densities[::-1]
    bare = turned * _IS_BARE
    found = (unchanged + drawn) * densities + turned - bare + bare.sum(axis=1, keepdims=True) * _BARE_ROADS
    return np.asarray(unchanged * found + (1.0 - unchanged) * found.sum(axis=1, keepdims=True) * ROADS)
