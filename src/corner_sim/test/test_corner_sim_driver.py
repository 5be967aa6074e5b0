"""The driver's foot."""

import pytest

from corner_sim.driver import DriverProfile


def test_a_step_is_there_from_its_start_until_its_end() -> None:
    driver = DriverProfile(pressure=8e6, start=0.5, rise=0.0, hold=1.0, release=0.0)
    assert [driver.demand(time) for time in (0.0, 0.495, 0.5, 1.495, 1.5, 9.0)] == [0.0, 0.0, 8e6, 8e6, 0.0, 0.0]


def test_ramps_run_linearly_up_and_down() -> None:
    driver = DriverProfile(pressure=4e6, start=1.0, rise=0.4, hold=0.6, release=0.2)
    expected = {1.0: 0.0, 1.1: 1e6, 1.3: 3e6, 1.4: 4e6, 1.9: 4e6, 2.05: 3e6, 2.15: 1e6, 2.2: 0.0, 5.0: 0.0}
    for time, pressure in expected.items():
        assert driver.demand(time) == pytest.approx(pressure, abs=1e-3)


@pytest.mark.parametrize("name", ["pressure", "start", "rise", "hold", "release"])
@pytest.mark.parametrize("value", [-1.0, float("nan")])
def test_a_profile_that_makes_no_sense_is_refused_by_name(name: str, value: float) -> None:
    values = {"pressure": 1.0, "start": 1.0, "rise": 1.0, "hold": 1.0, "release": 1.0}
    with pytest.raises(ValueError, match=name):
        DriverProfile(**(values | {name: value}))
