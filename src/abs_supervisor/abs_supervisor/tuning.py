"""Physical quantities of abs_supervisor that a user does not set; a healthy brake's safety hangs on them."""

from dataclasses import dataclass

from friction_parameters.parameter import constant


@dataclass(frozen=True)
class EvidenceTuning:
    """What counts as evidence."""

    least_slip: float = constant(0.03, "no release below this slip")
    lambda_max_share: float = constant(0.5, "a release needs a slip above this share of the curve's lambda_max")
    slip_without_curve: float = constant(0.2, "a release needs this slip where no curve is known")
    deceleration: float = constant(1.3, "or a deceleration of the wheel above this", unit="g")
    deceleration_margin: float = constant(0.3, "and above the car's own deceleration by this", unit="g")
    evidence_time: float = constant(0.01, "time for which slip or deceleration must be above", unit="s")
    sigmas: float = constant(3.0, "both must be above by this many standard deviations of their errors")

    def __post_init__(self) -> None:
        """Refuse thresholds in the wrong order."""
        if not self.least_slip <= self.slip_without_curve:
            raise ValueError(f"least_slip ({self.least_slip}) must not be above {self.slip_without_curve}")


@dataclass(frozen=True)
class CapTuning:
    """Limits of a release."""

    longest: float = constant(
        0.3,
        "longest release at a time, unless the slip is above its threshold and the wheel is seen to recover, or wheels "
        "stand that the brake still holds",
        unit="s",
    )
    window: float = constant(2.0, "window over which releases are added up", unit="s")
    most_in_window: float = constant(1.0, "most time released in it", unit="s")
    return_rate: float = constant(2000.0, "fastest rise of brake torque after a cap", unit="N m/s")
    return_time: float = constant(0.1, "least time after a cap before the next release", unit="s")
    driver_below: float = constant(1.5, "below this speed of the car the driver has the brake", unit="m/s")

    def __post_init__(self) -> None:
        """Refuse a cap that cannot act."""
        if not self.most_in_window < self.window:
            raise ValueError(f"most_in_window ({self.most_in_window}) must be below window ({self.window})")


@dataclass(frozen=True)
class EnvelopeTuning:
    """What is evidence for a release, and how long one may last."""

    evidence: EvidenceTuning = EvidenceTuning()
    caps: CapTuning = CapTuning()


@dataclass(frozen=True)
class Tuning:
    """All of them."""

    envelope: EnvelopeTuning = EnvelopeTuning()
    torque_band: float = constant(20.0, "smallest error of the brake torque that the law answers", unit="N m")
