"""Packaging of friction_parameters."""

from setuptools import find_packages, setup

package_name = "friction_parameters"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
    ],
    zip_safe=True,
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Parameters as typed dataclasses: one definition for code, files, nodes and tables. No ROS.",
    license="Apache-2.0",
    entry_points={"console_scripts": []},
)
