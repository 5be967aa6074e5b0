"""Packaging of friction_slope."""

from glob import glob

from setuptools import find_packages, setup

package_name = "friction_slope"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
        ("share/" + package_name + "/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools", "numpy"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    url="https://friction.example.org",
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Sign of the slope of the friction curve, equations (8.3) to (8.5).",
    license="Apache-2.0",
    entry_points={"console_scripts": ["friction_slope_node = friction_slope.ros.node:main"]},
)
