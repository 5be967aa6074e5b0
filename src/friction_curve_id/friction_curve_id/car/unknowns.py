"""Unknowns of a braking, as indices of one vector, and how the fit scales them.

The fit works on z = (unknown - mean) / stddev of the prior. An unknown that is known exactly has the deviation zero:
its column of every Jacobian vanishes, and it stays where it is.
"""

from enum import IntEnum


class Unknown(IntEnum):
    """Index of an unknown that the wheels share; the offset of the slip of each wheel follows."""

    LOG_MU_MAX = 0
    LOG_LAMBDA_MAX = 1
    SHAPE_1 = 2
    """Parameters of shape, see curve_family."""
    SHAPE_2 = 3
    LOG_GAIN_FRONT = 4
    """ln of the brake gain over that of the vehicle file."""
    LOG_GAIN_REAR = 5
    LOG_MASS = 6
    LOG_INERTIA = 7
    PRESSURE_DELAY = 8
    """Age of a pressure at its stamp [s]."""
    ACCELEROMETER_DELAY = 9
    """Age of an acceleration at its stamp [s]."""
    RELAXATION_LENGTH = 10
    """[m]"""
    START_SPEED = 11
    """Speed at the start of the window less that of the wheels there [m/s]."""
    ACCELEROMETER_OFFSET = 12
    """[m/s^2]"""
    SLOPE = 13
    """Acceleration by which gravity slows the car, uphill positive [m/s^2]."""
    ACCELEROMETER_SCALE = 14
    """Reading over specific force, less 1, without that of the pitch [-]."""
    ENGINE_DRAG = 15
    """Torque at each driven wheel, braking positive [N m]."""
    LOG_HEIGHT_RATIO = 16
    """ln of h / L over that of the vehicle file."""
    FRONT_LOAD_SHARE = 17
    LOG_PITCH_FREQUENCY = 18
    """ln of the natural frequency of pitch [rad/s]."""
    PITCH_DAMPING = 19
    """Its damping ratio."""
    DAMPER_SHARE = 20
    """Share of the dampers in the load transfer."""
    PITCH_READING = 21
    """Reading of the accelerometer by the pitch over the specific force that makes it [-]."""

    CURVE = 22
    """Share by which the left wheels run faster than the car, and the right ones slower, at the start [-]."""
    FADING = 23
    """Share of its gain that a brake loses with the work of FADING_WORK [-]."""
    CURVE_RATE = 24
    """Growth of CURVE, which is that at the start of the window of the braking [1/s]."""
    LOG_ACROSS = 25
    """ln of the friction of a tyre across over that along."""
    FRONT_ROLL_SHARE = 26
    """Share of the roll moment that the front axle takes."""
    LATERAL_OFFSET = 27
    """Of the accelerometer across the car, to the left [m/s^2]."""
    SIDEWAYS = 28
    """Sideways speed at the start, to the left [m/s]."""


OF_CURVE = slice(Unknown.LOG_MU_MAX, Unknown.SHAPE_2 + 1)
"""What belongs to the road; all else is the car's."""
OF_CURVES = (Unknown.LOG_ACROSS, Unknown.LATERAL_OFFSET, Unknown.SIDEWAYS)
"""What moves no wheel on a straight road."""
FADING_WORK = 1e5
"""[J]"""


SHARED = len(Unknown)
"""Number of unknowns that are shared; unknown SHARED + i is the offset of the slip of wheel i [-]."""
