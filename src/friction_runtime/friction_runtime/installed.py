"""Installed message types by their names, and the parameter files that packages ship."""

import re
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

from friction_parameters.command_line import UserError

TYPE_NAME: Final = re.compile(r"[a-z][a-z0-9_]*/(msg/)?[A-Za-z]\w*", re.ASCII)
"""Names of types, such as sensor_msgs/msg/JointState."""


class UnknownTypeError(UserError):
    """A message type is not installed; the text names the type and the package."""


@cache
def message_class(type_name: str) -> type:
    """Return the Python class of an installed type.

    Raises:
        UnknownTypeError: the type is not installed.
    """
    package, _, name = type_name.partition("/")
    try:
        if not TYPE_NAME.fullmatch(type_name):
            raise ImportError(f"{type_name!r} is not the name of a type")
        get_package_share_directory(package)  # only packages of ROS are imported, whatever a bag names
        return getattr(import_module(f"{package}.msg"), name.removeprefix("msg/"))
    except (ImportError, AttributeError, PackageNotFoundError, ValueError) as error:
        raise UnknownTypeError(f"type {type_name} is not installed: install or build package {package}") from error


def shipped_file(package: str, name: str = "") -> Path:
    """Return the path of a package's parameter file: `name`, or the one named like the package.

    Raises:
        PackageNotFoundError: the package is not installed.
    """
    return Path(get_package_share_directory(package), "config", f"{name or package}.yaml")


def shipped_parameters(node: str) -> Any:
    """Return the values of the parameter file named like the node's package: an instance of the node's dataclass."""
    return import_module(f"{node}.parameters").SHIPPED[node].parameters
