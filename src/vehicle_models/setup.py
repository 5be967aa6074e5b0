"""Packaging of vehicle_models."""

from setuptools import find_packages, setup

package_name = "vehicle_models"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed", "vehicles/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
    ],
    install_requires=["setuptools", "numpy"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    url="https://friction.example.org",
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Pure numpy models of tyre, wheel, brake and vehicle.",
    license="Apache-2.0",
)
