"""Tooth table: true angles of the encoder's crossings, and location of a revolution in it.

Teeth are not quite equal, the ring is not quite centred, and a second harmonic moves falling against rising crossings:
the angle of crossing k of a revolution is k pi/teeth + d_k. The d_k are learned from driving. They are also a
fingerprint: one revolution of crossings identifies every tooth, so the absolute angle survives a restart, a missed
tooth or a lost packet. Turning backwards does not fit the fingerprint.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_REVOLUTIONS = 16
"""Revolutions of one batch of learning: long against the once-per-revolution part, short against changes of speed."""
_DEGREE = 3
"""Degree of the polynomial in the crossing number that stands for the motion of the wheel."""
_BATCH_RESIDUAL = np.radians(0.05)
"""Largest RMS residual of a batch [rad]: above it the wheel did not turn evenly enough to learn from."""
_FLAT = np.radians(0.005)
"""RMS of d_k [rad] below which the teeth cannot be distinguished."""
_AMBIGUOUS = 0.5
"""Largest ratio of the squared residuals of the best place to those of the second best."""


def _basis(count: int) -> Array:
    """Orthonormal polynomials in the crossing number, shape (count, degree + 1)."""
    powers = np.vander(np.linspace(-1.0, 1.0, count), _DEGREE + 1)
    return np.asarray(np.linalg.qr(powers)[0])


@dataclass(frozen=True)
class Place:
    """Where in the table a run of crossings begins."""

    index: int
    """Table index of its first crossing."""
    certain: bool
    """False where the teeth are too similar to distinguish: the place is then a new convention."""


class ToothTable:
    """Deviations d_k of the crossings of one wheel."""

    def __init__(self, deviations: Array) -> None:
        """Take the deviations [rad], shape (2 teeth,).

        Raises:
            ValueError: a deviation is not finite or exceeds half a crossing, or their number is odd.
        """
        self.deviations = np.asarray(deviations, dtype=np.float64)
        count = len(self.deviations)
        if count % 2 or count == 0 or not np.all(np.abs(self.deviations) < np.pi / count):
            raise ValueError("tooth table: needs an even number of finite deviations below half a crossing")
        self.step = 2.0 * np.pi / count
        """Nominal angle between crossings [rad]."""
        self._basis = _basis(count)
        rolled = np.stack([np.roll(self.deviations, -shift) for shift in range(count)])
        self._prints = rolled - (rolled @ self._basis) @ self._basis.T

    def __len__(self) -> int:
        """Crossings per revolution."""
        return len(self.deviations)

    def angles(self, numbers: NDArray[np.int64]) -> Array:
        """Return the wheel angle [rad] at crossings counted from table index 0."""
        return np.asarray(numbers * self.step + self.deviations[numbers % len(self)])

    def place(self, times: Array) -> Place | None:
        """Locate one revolution of crossing times, shape (2 teeth,); None where no place fits, or two fit alike."""
        if np.sqrt(np.mean(self.deviations**2)) < _FLAT:
            return Place(0, certain=False)
        rate = self.step * (len(times) - 1) / (times[-1] - times[0])
        seen = (times - times[0]) * rate
        seen = seen - self._basis @ (self._basis.T @ seen)
        squares = np.sum((self._prints - seen) ** 2, axis=1)
        best, second = np.argsort(squares, kind="stable")[:2]
        if squares[best] > _AMBIGUOUS * squares[second]:
            return None
        return Place(int(best), certain=True)


class ToothTableLearner:
    """Learns a tooth table from uninterrupted crossings, batch after batch."""

    def __init__(self, teeth: int, batches: int = 2) -> None:
        """Be ready after `batches` batches during which the wheel turned evenly."""
        self._count = 2 * teeth
        self._batches = batches
        self._basis = _basis(_REVOLUTIONS * self._count)
        self.restart()

    @property
    def batch_length(self) -> int:
        """Crossings of one batch: whole revolutions."""
        return len(self._basis)

    def restart(self) -> None:
        """Forget everything: the count of teeth was lost."""
        self._sum: Array = np.zeros(self._count)
        self._learned = 0

    def add(self, times: Array) -> ToothTable | None:
        """Take the next batch of crossing times [any unit]; return the table, from its first crossing, once learned."""
        deviations = self._batch(times)
        if deviations is None:
            return None
        self._sum = self._sum + deviations
        self._learned += 1
        return ToothTable(self._sum / self._learned) if self._learned == self._batches else None

    def _batch(self, times: Array) -> Array | None:
        step = 2.0 * np.pi / self._count
        number = np.arange(len(times))
        rate = step / np.gradient(self._basis @ (self._basis.T @ (times - times[0])))
        table = np.zeros(self._count)
        for _ in range(3):
            # Motion and table in turn: they overlap very little over 16 revolutions.
            clean = times - times[0] - table[number % self._count] / rate
            motion = self._basis @ (self._basis.T @ clean)
            left = (clean - motion) * rate
            table = table + left.reshape(_REVOLUTIONS, self._count).mean(axis=0)
            table -= table.mean()
        left = (times - times[0] - motion) * rate - table[number % self._count]
        return table if np.sqrt(np.mean(left**2)) < _BATCH_RESIDUAL else None
