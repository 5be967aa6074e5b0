"""Checksum of a brake command, by which a consumer knows that no bit of it was changed on the way."""

from struct import pack
from zlib import crc32

from friction_msgs.msg import BrakeCommand

from friction_runtime.messages import to_nanoseconds


def checksum(message: BrakeCommand) -> int:
    """Return the CRC-32 (IEEE 802.3) over stamp, command, counter, validity and wheel of a command.

    Little endian and without gaps: stamp [ns] (int64), command (uint8), counter (uint32), valid_for [s] (float64),
    wheel (UTF-8).
    """
    stamp = to_nanoseconds(message.header.stamp)
    fixed = pack("<qBId", stamp, message.command, message.counter, message.valid_for)
    return crc32(fixed + message.wheel.encode())


def sealed(message: BrakeCommand) -> BrakeCommand:
    """Return the message with its checksum."""
    message.checksum = checksum(message)
    return message
