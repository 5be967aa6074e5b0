"""Contact patch and forces as messages."""

from math import nan

from friction_msgs.msg import ContactPatch, TyreForce
from geometry_msgs.msg import Vector3, Wrench, WrenchStamped
from std_msgs.msg import Header

from friction_runtime.messages import validity
from smart_tyre_forces.calibration import TyreCalibration
from smart_tyre_forces.correction import Patch
from smart_tyre_forces.forces import Forces, length_stddev, shift_stddev


def contact_patch(header: Header, wheel: str, patch: Patch, tyre: TyreCalibration | None) -> ContactPatch:
    """Make <wheel>/contact_patch."""
    return ContactPatch(
        header=header,
        wheel=wheel,
        revolution=patch.passage.revolution,
        alpha_1=patch.alpha_1,
        alpha_2=patch.alpha_2,
        length_raw=patch.length_raw,
        shift_raw=patch.shift_raw,
        length=patch.length,
        shift=patch.shift,
        length_stddev=nan if tyre is None else length_stddev(tyre, patch),
        shift_stddev=nan if tyre is None else shift_stddev(tyre, patch),
        wheel_speed=patch.passage.wheel_speed,
        validity=validity(wheel, patch.reason, patch.text),
    )


def tyre_force(header: Header, wheel: str, forces: Forces) -> TyreForce:
    """Make <wheel>/tyre_force."""
    return TyreForce(
        header=header,
        wheel=wheel,
        fx=forces.fx,
        fz=forces.fz,
        fx_stddev=forces.fx_stddev,
        fz_stddev=forces.fz_stddev,
        validity=validity(wheel, forces.reason, forces.text),
    )


def tyre_wrench(header: Header, forces: Forces) -> WrenchStamped:
    """Make <wheel>/tyre_wrench."""
    return WrenchStamped(header=header, wrench=Wrench(force=Vector3(x=forces.fx, y=nan, z=forces.fz)))
