"""One changed tyre is distinguished from four where four wheels are known."""

import pytest

from smart_tyre_forces.tyre_comparison import TyreComparison
from smart_tyre_forces.tyre_gain import TyreGain

WHEELS = ("FL", "FR", "RL", "RR")


def verdicts(lengths: tuple[float, ...], stddev: float = 0.01) -> list[str]:
    comparison = TyreComparison()
    comparison.gains = {
        name: TyreGain(length=length, length_stddev=stddev) for name, length in zip(WHEELS, lengths, strict=False)
    }
    return [comparison.verdict(name) for name in WHEELS[: len(lengths)]]


@pytest.mark.parametrize(
    ("lengths", "said"),
    [
        ((1.1, 1.0, 1.01, 0.99), "this tyre"),
        ((1.1, 1.12, 1.09, 1.1), "all tyres"),
        ((1.1, 1.0, 1.1, 1.0), "as RL: these tyres"),
        ((1.1, 1.0), "cannot be distinguished"),
        ((0.9, 1.0, 1.0, 1.0), "-10 %"),
    ],
)
def test_verdict_on_a_tyre_that_differs(lengths: tuple[float, ...], said: str) -> None:
    assert said in verdicts(lengths)[0]


def test_tyres_as_calibrated_and_tyres_not_known_yet_are_not_spoken_of() -> None:
    assert verdicts((1.1, 1.0, 1.01, 0.99))[1:] == ["", "", ""]
    assert verdicts((1.1, 1.1, 1.1, 1.1), stddev=0.1) == [""] * 4
