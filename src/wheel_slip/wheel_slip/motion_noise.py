"""Table of what the filter of the car's motion does not know, each as a deviation of one standard deviation."""

from dataclasses import dataclass
from math import log, sqrt

from friction_parameters.parameter import constant


@dataclass(frozen=True)
class MotionNoise:
    """Physical quantities that a user does not set."""

    step: float = constant(0.02, "time from one correction by the wheels to the next; age of a pressure", unit="s")
    acceleration: float = constant(0.1, "noise of a sample of the accelerometer", unit="m/s^2")
    jerk: float = constant(10.0, "change of the acceleration in the square root of a second", unit="m/s^2")
    offset: float = constant(0.4, "offset of the accelerometer and slope of the road at the start", unit="m/s^2")
    offset_walk: float = constant(1e-3, "change of the offset in the square root of a second", unit="m/s^2")
    gain: float = constant(0.02, "gain of the accelerometer, where the vehicle file states none, as a share")
    slope: float = constant(0.5, "change of the road's slope times g", unit="m/s^2")
    slope_length: float = constant(40.0, "way on which a slope changes", unit="m")
    slope_every: float = constant(400.0, "way from one change of slope to the next", unit="m")
    slope_known: float = constant(0.05, "deviation of a slope that is known again", unit="m/s^2")
    misread: float = constant(3.0, "change of a car's acceleration in the square root of a second", unit="m/s^2")
    fault_every: float = constant(1e5, "time from one fault of accelerometer or brake torques to the next", unit="s")
    fault_time: float = constant(60.0, "time for which it lasts at least", unit="s")
    lateral: float = constant(2.0, "lateral acceleration of ordinary driving", unit="m/s^2")
    curve_time: float = constant(1.0, "time in which a curve comes and goes", unit="s")
    sideslip: float = constant(0.1, "angle of the body against its way in a curve", unit="rad")
    gyroscope: float = constant(0.045, "noise and offset of a yaw rate", unit="rad/s")
    compliance: float = constant(0.006, "slip over force to expect", unit="s^2/m")
    compliance_stddev: float = constant(0.05, "its deviation", unit="s^2/m")
    compliance_unlike: float = constant(2.0, "deviation of that of a tyre on its curve, as a share")
    share: float = constant(0.1, "deviation of the share of the largest force that a tyre gives, as a share")
    another: float = constant(0.1, "slip by which a tyre goes on until its largest force may be another", unit="-")
    compliance_alike: float = constant(0.8, "correlation of it between the tyres")
    slide: float = constant(0.3, "slip of a tyre beyond its peak to expect")
    slide_stddev: float = constant(0.3, "its deviation: it may be locked")
    slide_alike: float = constant(0.8, "share of its variance that all tyres have in common")
    slide_time: float = constant(3.0, "time in which that is forgotten", unit="s")
    steepest: float = constant(1.5, "change of a wheel against the car that is no dive", unit="m/s^2")
    dive_time: float = constant(0.1, "time for which a dive keeps its rate", unit="s")
    creep: float = constant(3.0, "change of the slip speed at the peak in the square root of a second", unit="m/s")
    force: float = constant(0.05, "force that torques tell, over the load, times g", unit="m/s^2")
    blind_force: float = constant(0.6, "force that only the accelerometer tells, over the load, times g", unit="m/s^2")
    unread: float = constant(0.4, "share of the car's force that wheels do not tell which are all there is")
    pull: float = constant(0.2, "force of all tyres over the mass: bias of the accelerometer, drag", unit="m/s^2")
    engine: float = constant(1.0, "force of the engine over the mass, driving or braking", unit="m/s^2")
    engine_time: float = constant(3.0, "time for which that force may stay", unit="s")
    brakes: float = constant(0.06, "share by which all brakes together differ from their torques: friction of the pads")
    missed: float = constant(0.6, "largest share of the braking that a wrong pressure of one wheel misses")
    unequal: float = constant(30.0, "share by which the force of one wheel differs from that of the car")
    correlation: float = constant(0.1, "time for which the error of a force is one", unit="s")
    pressure_delay: float = constant(0.012, "age of a pressure that is not known", unit="s")
    radius: float = constant(0.002, "what a wheel's speed is off by over its radius: bumps, as a share")
    radius_walk: float = constant(1e-4, "change of a radius in the square root of a second, as a share")
    another_radius: float = constant(0.05, "radius of another tyre than the vehicle file's, as a share")
    another_tyre: float = constant(0.06, "share of wheels that have one", unit="-")
    quiet: float = constant(0.3, "variance of rim speeds where nothing happens, as a share of what is stated for them")
    wheel_fault_every: float = constant(1e4, "time from one fault of a wheel speed to the next", unit="s")
    failed: float = constant(5.0, "time for which a wheel that was such a surprise is not believed", unit="s")
    unknown_acceleration: float = constant(5.0, "acceleration in the square root of a second, unseen", unit="m/s^2")

    @property
    def surprise(self) -> float:
        """Deviations [-] from what the others say beyond which a fault in this step is the likelier reason."""
        return sqrt(2.0 * log(self.wheel_fault_every / self.step))
