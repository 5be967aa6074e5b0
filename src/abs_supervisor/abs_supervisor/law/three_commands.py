"""Three-level command nearest to a torque set-point."""

from vehicle_models.brake_actuator import Command


def command_towards(wanted: float, torque: float, demand: float, band: float) -> Command:
    """Return the command.

    Args:
        wanted: torque to aim at [N m].
        torque: of the brake when the command acts [N m].
        demand: of the driver [N m], the ceiling: a torque that reaches it is his.
        band: smallest error that a command answers [N m].
    """
    if wanted >= demand - band or torque > demand:
        return Command.INCREASE
    error = wanted - torque
    if error > band:
        return Command.INCREASE
    return Command.DECREASE if error < -band else Command.HOLD
