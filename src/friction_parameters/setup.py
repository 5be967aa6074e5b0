"""Packaging of friction_parameters."""

from setuptools import find_packages, setup

package_name = "friction_parameters"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
    ],
    install_requires=["setuptools", "PyYAML"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    url="https://friction.example.org",
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Parameters as typed dataclasses: one definition for code, files, nodes and tables. No ROS.",
    license="Apache-2.0",
)
