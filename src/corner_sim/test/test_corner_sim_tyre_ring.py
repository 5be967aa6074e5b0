import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from corner_sim.smart_tyre.tyre_ring import TyreRing

RING = TyreRing()
EDGE = RING.half_patch


@pytest.mark.parametrize("edge_deg", [8.0, 12.5, 17.0])
def test_belt_is_continuous_in_depth_and_slope_at_the_edge_of_the_patch(edge_deg: float) -> None:
    edge, step = np.radians(edge_deg), 1e-6
    r = RING.belt_radius(edge + step * np.array([-2.0, -1.0, 1.0, 2.0]), edge)
    assert abs(r[2] - r[1]) < 1e-6
    assert (r[1] - r[0]) / step == pytest.approx((r[3] - r[2]) / step, rel=1e-3)


def test_belt_is_flat_in_the_patch_and_bulges_beside_it() -> None:
    inside = np.linspace(-EDGE, EDGE, 101)[1:-1]
    assert np.ptp(RING.belt_radius(inside, EDGE) * np.cos(inside)) < 1e-12
    assert RING.belt_radius(np.pi, EDGE) == pytest.approx(RING.radius, rel=1e-6)
    beside = RING.belt_radius(np.linspace(EDGE, EDGE + 0.8, 200), EDGE)
    assert np.max(beside) > RING.radius


@pytest.mark.parametrize("edge_deg", [8.0, 12.5, 17.0])
def test_acceleration_shape_is_r_less_its_second_derivative_away_from_the_rounded_edge(edge_deg: float) -> None:
    sharp = TyreRing(bending_angle=float(np.radians(0.1)))
    edge, step = np.radians(edge_deg), 1e-3
    outside = np.linspace(edge + 6.0 * sharp.bending_angle, 2.5, 60)
    inside = np.linspace(0.0, edge - 6.0 * sharp.bending_angle, 20)
    for theta in (outside, inside, -outside):
        r = [sharp.belt_radius(theta + k * step, edge) for k in (-1, 0, 1)]
        expected = r[1] - (r[0] - 2.0 * r[1] + r[2]) / step**2
        np.testing.assert_allclose(sharp.acceleration_shape(theta, edge), expected, atol=1e-3 * RING.radius)


def test_rounding_the_edge_keeps_the_mean_acceleration() -> None:
    sharp = TyreRing(bending_angle=float(np.radians(0.05)))
    theta = np.linspace(-np.pi, np.pi, 400_001)
    means = [float(np.mean(ring.acceleration_shape(theta, EDGE))) for ring in (RING, sharp)]
    assert means[0] == pytest.approx(means[1], rel=2e-4)


def test_closed_belt_has_no_net_second_derivative() -> None:
    # The mean of r'' over a closed smooth curve is zero, so the shape has the mean of r.
    theta = np.linspace(-np.pi, np.pi, 400_001)
    shape, radius = RING.acceleration_shape(theta, EDGE), RING.belt_radius(theta, EDGE)
    assert np.mean(shape) == pytest.approx(np.mean(radius), rel=2e-3)


def test_twin_spike_stands_over_the_centripetal_level_and_the_patch_is_near_zero() -> None:
    theta = np.linspace(-np.pi, np.pi, 20_001)
    shape = RING.acceleration_shape(theta, EDGE)
    np.testing.assert_allclose(shape, shape[::-1], atol=1e-9)
    assert np.max(np.abs(shape[np.abs(theta) < EDGE - 6.0 * RING.bending_angle])) < 0.1 * RING.radius
    assert shape[0] == pytest.approx(RING.radius, rel=1e-3)
    assert 1.5 * RING.radius < np.max(shape) < 2.5 * RING.radius
    peak = abs(theta[np.argmax(shape)])
    assert EDGE < peak < EDGE + 0.2


@given(load=st.floats(0.4, 1.8), pressure=st.floats(1.2e5, 3e5), speed=st.floats(0.0, 35.0))
def test_patch_grows_with_load_and_shrinks_with_pressure_and_speed(load: float, pressure: float, speed: float) -> None:
    fz = load * RING.static_load
    angle = RING.patch_half_angle(fz, pressure, speed)
    assert RING.patch_half_angle(1.01 * fz, pressure, speed) / angle == pytest.approx(1.01**0.7)
    assert RING.patch_half_angle(fz, 1.01 * pressure, speed) < angle
    assert RING.patch_half_angle(fz, pressure, speed + 1.0) < angle


def test_patch_and_shift_have_the_sizes_of_the_chapter() -> None:
    assert np.degrees(2.0 * RING.patch_half_angle(RING.static_load, 2e5, 0.0)) == pytest.approx(25.0)
    longer = RING.patch_half_angle(RING.static_load, 1.6e5, 0.0) / RING.half_patch
    assert longer == pytest.approx(0.8**-0.3)
    stiffened = 2e5 + 12.0 * 20.0**2 / 0.32
    assert RING.patch_half_angle(RING.static_load, 2e5, 20.0) == pytest.approx(
        RING.half_patch * (stiffened / 2e5) ** -0.3
    )
    assert -3.5 < np.degrees(RING.patch_shift(-4000.0, RING.static_load, 2e5, 0.0)) < -2.0


def test_shift_has_the_sign_of_the_force_and_is_slightly_nonlinear() -> None:
    one, two = (float(RING.patch_shift(fx, RING.static_load, 2e5, 0.0)) for fx in (2000.0, 4000.0))
    assert 1.9 * one < two < 2.0 * one
    assert RING.patch_shift(-2000.0, RING.static_load, 2e5, 0.0) == pytest.approx(-one)
    softer = float(RING.patch_shift(2000.0, RING.static_load, 1.6e5, 0.0))
    assert softer / one == pytest.approx(0.8**-0.25, rel=5e-3)


def test_cross_talk_is_minus_beta_times_the_longer_patch_and_the_trend_a_hundredth_of_a_degree() -> None:
    fz = 1.2 * RING.static_load
    longer = 2.0 * (RING.patch_half_angle(fz, 2e5, 0.0) - RING.half_patch)
    assert RING.patch_shift(0.0, fz, 2e5, 0.0) == pytest.approx(-0.08 * longer)
    assert np.degrees(RING.patch_shift(0.0, RING.static_load, 2e5, 10.0)) == pytest.approx(0.1)
