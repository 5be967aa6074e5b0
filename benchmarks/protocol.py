"""The chapter's protocol (section 8.3.2): its corner, initial speed and sample time."""

from vehicle_models.vehicle_file import load_vehicle

VEHICLE = "chapter_corner"
CAR = load_vehicle(VEHICLE)
"""A car of one wheel."""
WHEEL = CAR.wheel_names[0]
CORNER = CAR.corner(WHEEL)
BRAKE_GAIN = CAR.wheel(WHEEL).brake_gain
"""k in T_b = k p [N m/Pa]."""
SPEED = 30.0
"""At the start, rolling freely [m/s]."""
DT = 0.005
"""Sample time [s]."""
STEP = 5_000_000
"""Sample time [ns]."""
ACCELERATION_STDDEV = 0.1
"""Noise of the accelerometer [m/s^2]: the chapter gives none, and wheel_slip is tuned for this."""
