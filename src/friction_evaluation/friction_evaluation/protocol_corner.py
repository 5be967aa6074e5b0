"""The corner of the chapter's protocol (section 8.3.2)."""

from vehicle_models.vehicle_file import load_vehicle

VEHICLE = "chapter_corner"
CAR = load_vehicle(VEHICLE)
"""A car of one wheel."""
WHEEL = CAR.wheel_names[0]
CORNER = CAR.corner(WHEEL)
BRAKE_GAIN = CAR.wheel(WHEEL).brake_gain
"""k of T_b = k p [N m/Pa]."""
