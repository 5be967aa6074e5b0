"""Arrows of the tyres' forces as markers for rviz and Foxglove."""

from builtin_interfaces.msg import Duration
from friction_msgs.msg import FrictionState, WheelState
from geometry_msgs.msg import Point, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from friction_state.force_arrows import Arrow, Colour, contact_patch, force_arrows, grip_colour
from vehicle_models.vehicle import Vehicle

_SHAFT, _HEAD = 0.06, 0.14
"""Diameters of an arrow [m]."""


def force_markers(state: FrictionState, vehicle: Vehicle) -> MarkerArray:
    """Return Fx and Fz of each wheel as arrows; what is not valid is deleted, so that no old arrow stays."""
    markers = MarkerArray()
    for number, (wheel, of_wheel) in enumerate(zip(vehicle.wheels, state.wheels, strict=True)):
        place = contact_patch(vehicle, wheel)
        mu_max = of_wheel.mu_max if of_wheel.curve_valid else float("nan")
        colour = grip_colour(of_wheel.fx, of_wheel.fz, mu_max)
        for name, arrow in zip(("fx", "fz"), force_arrows(place, of_wheel.fx, of_wheel.fz), strict=True):
            markers.markers.append(_marker(state.header, name, number, of_wheel, arrow, colour))
    return markers


def _marker(header: Header, name: str, number: int, wheel: WheelState, arrow: Arrow, colour: Colour) -> Marker:
    marker = Marker(header=header, ns=name, id=number, type=Marker.ARROW, action=Marker.DELETE, lifetime=Duration())
    marker.pose.orientation.w = 1.0
    if wheel.force_valid:
        marker.action = Marker.ADD
        marker.points = [Point(x=x, y=y, z=z) for x, y, z in (arrow.tail, arrow.tip)]
        marker.scale = Vector3(x=_SHAFT, y=_HEAD, z=0.0)
        marker.color = ColorRGBA(r=colour[0], g=colour[1], b=colour[2], a=1.0)
        marker.text = f"{wheel.wheel} {name}"
    return marker
