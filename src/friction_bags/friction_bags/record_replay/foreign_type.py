"""Messages of types that are not installed, as bytes: DDS needs no more than the name of the type.

rclpy needs a message class with type support. The one made here has the name of the foreign type and otherwise the
functions of std_msgs/String, which are never called as long as messages pass as bytes. It works with the
rmw_fastrtps_cpp middleware of Jazzy, the default; with another one the type stays unknown.
"""

import ctypes
from functools import cache
from typing import Any

from std_msgs.msg import String

from friction_runtime.message_type import UnknownTypeError, message_class

_FASTRTPS = b"rosidl_typesupport_fastrtps_c"
_INTROSPECTION = b"rosidl_typesupport_introspection_c"
_HASH_SIZE = 32


class _TypeSupport(ctypes.Structure):
    """rosidl_message_type_support_t."""

    _fields_ = (
        ("identifier", ctypes.c_char_p),
        ("data", ctypes.c_void_p),
        ("handle_function", ctypes.c_void_p),
        ("hash_function", ctypes.c_void_p),
        ("description_function", ctypes.c_void_p),
        ("sources_function", ctypes.c_void_p),
    )


class _Callbacks(ctypes.Structure):
    """message_type_support_callbacks_t of rosidl_typesupport_fastrtps_cpp."""

    _fields_ = (
        ("namespace", ctypes.c_char_p),
        ("name", ctypes.c_char_p),
        ("functions", ctypes.c_void_p * 5),
    )


class _TypeHash(ctypes.Structure):
    """rosidl_type_hash_t."""

    _fields_ = (("version", ctypes.c_uint8), ("value", ctypes.c_uint8 * _HASH_SIZE))


_HandleFunction = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p)
_HashFunction = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)


def raw_class(type_name: str, type_hash: str) -> Any:
    """Return a class with which messages of a type pass as bytes: the installed one, or one made for it.

    Args:
        type_name: e.g. test_msgs/msg/BasicTypes.
        type_hash: RIHS01 hash of the type, empty where unknown.

    Raises:
        UnknownTypeError: the type is not installed, and the middleware does not support such a class.
    """
    try:
        return message_class(type_name)
    except UnknownTypeError:
        return foreign_class(type_name, type_hash)


@cache
def foreign_class(type_name: str, type_hash: str) -> Any:
    """Return a class for bytes of a type, whether it is installed or not; see raw_class."""
    package, _, name = type_name.partition("/msg/")
    fastrtps, introspection = _support_of_string(_FASTRTPS), _support_of_string(_INTROSPECTION)
    if not (fastrtps and introspection and name):
        raise UnknownTypeError(f"type {type_name} is not installed: install or build package {package}")
    made = _TypeSupport.from_buffer_copy(_TypeSupport.from_address(fastrtps))
    callbacks = _Callbacks.from_buffer_copy(_Callbacks.from_address(made.data))
    callbacks.namespace = f"{package}::msg".encode()
    callbacks.name = name.encode()
    made_hash = _type_hash(type_hash)
    handles = {_FASTRTPS: ctypes.addressof(made), _INTROSPECTION: introspection}
    handle_function = _HandleFunction(lambda _, identifier: handles.get(identifier))
    hash_function = _HashFunction(lambda _: ctypes.addressof(made_hash))
    made.data = ctypes.addressof(callbacks)
    made.handle_function = ctypes.cast(handle_function, ctypes.c_void_p).value
    made.hash_function = ctypes.cast(hash_function, ctypes.c_void_p).value
    kept: Any = type(String)
    members = {
        member: getattr(kept, member)
        for member in ("_CREATE_ROS_MESSAGE", "_CONVERT_FROM_PY", "_CONVERT_TO_PY", "_DESTROY_ROS_MESSAGE")
    }
    # objects that C code points to must live as long as the class
    members["_ALIVE"] = (callbacks, made_hash, handle_function, hash_function, made)
    members["_TYPE_SUPPORT"] = _capsule(made)
    return type(f"Metaclass_{name}", (type,), members)(name, (), {})


def _support_of_string(identifier: bytes) -> int | None:
    """Return the address of a type support of std_msgs/String; None where it is not installed."""
    kind: Any = type(String)
    if kind._TYPE_SUPPORT is None:
        kind.__import_type_support__()
    pointer_of = ctypes.pythonapi.PyCapsule_GetPointer
    pointer_of.restype, pointer_of.argtypes = ctypes.c_void_p, (ctypes.py_object, ctypes.c_char_p)
    name_of = ctypes.pythonapi.PyCapsule_GetName
    name_of.restype, name_of.argtypes = ctypes.c_char_p, (ctypes.py_object,)
    pointer = pointer_of(kind._TYPE_SUPPORT, name_of(kind._TYPE_SUPPORT))
    function = _HandleFunction(_TypeSupport.from_address(pointer).handle_function)
    return function(pointer, identifier)


def _capsule(support: _TypeSupport) -> Any:
    make = ctypes.pythonapi.PyCapsule_New
    make.restype, make.argtypes = ctypes.py_object, (ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)
    return make(ctypes.addressof(support), None, None)


def _type_hash(text: str) -> _TypeHash:
    """Return the hash as the middleware announces it; that of version 0 where it is unknown."""
    if not text.startswith("RIHS01_"):
        return _TypeHash()
    return _TypeHash(1, (ctypes.c_uint8 * _HASH_SIZE).from_buffer_copy(bytes.fromhex(text.removeprefix("RIHS01_"))))
