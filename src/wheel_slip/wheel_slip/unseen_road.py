"""Grade uncertainty: covariances of speed and bias kept beside those of the filter.

Two independent parts of the accelerometer's offset, b_1 that stays and b_2 that comes and goes with the way:

    v' = -b_1 - b_2,    b_1' = n_1,    b_2' = -b_2 |v| / L + n_2

b_1 walks while wheels that roll are braked, where slip and slope look alike, and takes the steps that wheels have shown
(`doubt`). b_2 is the slope of the road against that where a slide began: it reaches a deviation sigma within the length
L. So a step counts from the first metres of a slide on, and over a long one such steps average.
"""

from math import exp

Covariance = tuple[float, float, float]
"""Of speed [m^2/s^2], of both [m^2/s^3], of the offset [m^2/s^4]."""


class UnseenRoad:
    """Both parts, and their sum."""

    def __init__(self, walk: float, slope_stddev: float, slope_length: float) -> None:
        """Start with nothing unseen.

        Args:
            walk: change of b_1 in the square root of a second while it walks [m/s^2].
            slope_stddev: sigma [m/s^2].
            slope_length: L [m], above 0.
        """
        self._walk, self._slope, self._length = walk**2, slope_stddev**2, slope_length
        self.clear()

    def clear(self) -> None:
        """Know that nothing has happened unseen."""
        self._stays: Covariance = (0.0, 0.0, 0.0)
        self._passes: Covariance = (0.0, 0.0, 0.0)
        self.total: Covariance = (0.0, 0.0, 0.0)

    @property
    def passing_variance(self) -> float:
        """Of the offset, as far as it comes and goes with the way [m^2/s^4]."""
        return self._passes[2]

    def predict(self, dt: float, speed: float, *, sliding: bool) -> None:
        """Go on by `dt` [s] at a speed [m/s]; `sliding`: the wheels tell nothing of the slope, and else little."""
        self._stays = _after(self._stays, dt, 1.0, 0.0 if sliding else self._walk * dt)
        stay = exp(-dt * abs(speed) / self._length)
        self._passes = _after(self._passes, dt, stay, (1.0 - stay * stay) * self._slope if sliding else 0.0)
        self._sum()

    def doubt(self, variance: float) -> None:
        """Widen the offset that stays to at least a variance [m^2/s^4]."""
        speed, both, offset = self._stays
        self._stays = (speed, both, max(offset, variance))
        self._sum()

    def doubt_past(self, variance: float, ago: float) -> None:
        """Widen what stays as by a step of the offset `ago` [s] ago, of a variance [m^2/s^4]."""
        speed, both, offset = self._stays
        self._stays = (speed + variance * ago * ago, both - variance * ago, offset + variance)
        self._sum()

    def refer(self, total: float) -> None:
        """Know the speed, whose variance with that of what told it was `total` [m^2/s^2]; keep the offsets."""
        self._stays, self._passes = _referred(self._stays, total), _referred(self._passes, total)
        self._sum()

    def keep(self, share: float) -> None:
        """Know the speed better, to this share of the variance that the road has given it, in [0, 1]."""
        self._stays, self._passes = _kept(self._stays, share), _kept(self._passes, share)
        self._sum()

    def _sum(self) -> None:
        a, b = self._stays, self._passes
        self.total = (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _after(part: Covariance, dt: float, stay: float, new: float) -> Covariance:
    """Return a part after `dt` [s], when a share of the offset stays and a variance [m^2/s^4] has come to it."""
    speed, both, offset = part
    speed += dt * (dt * (offset + new / 3.0) - 2.0 * both)
    return speed, stay * (both - dt * offset) - 0.5 * dt * new, stay * stay * offset + new


def _kept(part: Covariance, share: float) -> Covariance:
    speed, both, offset = part
    return share * speed, share * both, offset - (1.0 - share) * both * both / speed if speed else offset


def _referred(part: Covariance, total: float) -> Covariance:
    """Return a part once the speed is known: the offset, as far as the speed did not tell it."""
    _, both, offset = part
    return 0.0, 0.0, offset - both * both / total
