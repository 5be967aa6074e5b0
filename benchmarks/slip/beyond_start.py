"""lambda_init read as "only samples beyond it": a method of the chapter that is not given those before."""

from benchmarks.protocol import CORNER
from friction_curve_id.chapter.curve_fitting import PointFitting
from friction_curve_id.chapter.friction_samples import FrictionSamples
from friction_curve_id.interface import CurveEstimate, Reason, Refusal, Sample
from friction_curve_id.methods import CHAPTER_METHODS


class BeyondStart:
    """CurveEstimator of one braking that begins with the first 20 samples beyond `lambda_init`.

    The chapter says that the methods are initialised beyond lambda_init. friction_curve_id begins there, with all the
    samples of the braking so far; this reading has only those that follow.
    """

    def __init__(self, method: str, lambda_init: float) -> None:
        """Make one of CHAPTER_METHODS; `lambda_init` is a slip [-]."""
        self._samples = FrictionSamples(CORNER)
        self._fitting = PointFitting(CHAPTER_METHODS[method]())
        self._lambda_init = lambda_init
        self.reset()

    def reset(self) -> None:
        """Forget the braking."""
        self._samples.reset()
        self._fitting.reset()
        self._begun = False

    def update(self, sample: Sample) -> CurveEstimate | Refusal:
        """Take the next sample."""
        point = self._samples.update(sample)
        if isinstance(point, Refusal):
            return point
        self._begun = self._begun or point.slip > self._lambda_init
        if not self._begun:
            return Refusal(Reason.TOO_FEW_SAMPLES, f"slip {point.slip:.3f} has not passed {self._lambda_init:.3f}")
        return self._fitting.update(point)
