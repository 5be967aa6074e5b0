"""Packaging of vehicle_models."""

from setuptools import find_packages, setup

package_name = "vehicle_models"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed", "vehicles/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
    ],
    zip_safe=True,
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Pure numpy models of tyre, wheel, brake and vehicle.",
    license="Apache-2.0",
    entry_points={"console_scripts": []},
)
