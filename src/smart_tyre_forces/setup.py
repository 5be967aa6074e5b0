"""Packaging of smart_tyre_forces."""

from glob import glob

from setuptools import find_packages, setup

package_name = "smart_tyre_forces"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
        ("share/" + package_name + "/config", glob("config/*.yaml")),
        ("share/" + package_name + "/calibration", glob("calibration/*.yaml")),
    ],
    install_requires=["setuptools", "matplotlib", "numpy", "PyYAML", "rich", "scipy"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    url="https://friction.example.org",
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Vertical and longitudinal tyre force from an in-tyre accelerometer and a wheel encoder.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "smart_tyre_forces_node = smart_tyre_forces.ros.node:main",
            "calibrate_smart_tyre = smart_tyre_forces.ros.calibration_tool:main",
        ]
    },
)
