"""Messages of the middleware as the bytes that it carries.

To convert a message field by field takes rclpy three to ten times as long. So a node takes and publishes bytes, and one
layout reads or writes a whole message; rclpy converts what no layout covers.
"""

from typing import Any, Final

from rclpy.serialization import deserialize_message

from friction_runtime.cdr_codec import LayoutCodec
from friction_runtime.new_message import bare_class

_codecs: Final[dict[Any, LayoutCodec]] = {}


def unpacked(data: bytes, kind: Any) -> Any:
    """Return the message in bytes from the middleware; sequences of numbers are arrays of numpy.

    Raises:
        ValueError: the data is not a message of this class.
    """
    codec = _codec_of(kind)
    message = codec.read(data)
    if message is not None:
        return message
    try:
        message = deserialize_message(data, kind)
    except Exception as error:  # rclpy has no common class for errors of its middleware
        raise ValueError(f"not a {kind.__name__}: {error}") from error
    codec.learn(data, message)
    return message


def packed(message: Any, kind: Any) -> Any:
    """Return a message as what a publisher takes: bytes, or the message itself where no layout covers its class."""
    data = _codec_of(kind).write(message)
    return message if data is None else data


def _codec_of(kind: Any) -> LayoutCodec:
    codec = _codecs.get(kind)
    if codec is None:
        codec = _codecs[kind] = LayoutCodec(kind, bare_class)
    return codec
