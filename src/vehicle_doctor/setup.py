"""Packaging of vehicle_doctor."""

from setuptools import find_packages, setup

package_name = "vehicle_doctor"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
    ],
    install_requires=["setuptools", "numpy", "PyYAML", "rich"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    url="https://friction.example.org",
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Examines the signals of a recorded drive: units, signs, delays, gains; learns the vehicle file from it.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["doctor = vehicle_doctor.__main__:main"]},
)
