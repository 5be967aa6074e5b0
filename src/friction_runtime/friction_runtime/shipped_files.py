"""Files that packages ship beside their code."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory


def shipped_file(package: str, name: str = "") -> Path:
    """Parameter file that a package ships: `name`, or the one named like the package.

    Raises:
        PackageNotFoundError: the package is not installed.
    """
    return Path(get_package_share_directory(package), "config", f"{name or package}.yaml")
