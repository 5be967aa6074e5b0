"""Parameter files that the packages of the nodes ship, and the values in them."""

from importlib import import_module
from pathlib import Path
from typing import Any

from ament_index_python.packages import get_package_share_directory


def shipped_file(package: str, name: str = "") -> Path:
    """Return the path of a package's parameter file: `name`, or the one named like the package.

    Raises:
        PackageNotFoundError: the package is not installed.
    """
    return Path(get_package_share_directory(package), "config", f"{name or package}.yaml")


def shipped_parameters(node: str) -> Any:
    """Return the values of the parameter file named like the node's package: an instance of the node's dataclass."""
    return import_module(f"{node}.parameters").SHIPPED[node].parameters
