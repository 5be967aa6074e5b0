"""Packaging of friction_grip."""

from glob import glob

from setuptools import find_packages, setup

package_name = "friction_grip"

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
    install_requires=["setuptools", "numpy", "scipy"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    url="https://friction.example.org",
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Friction that a drive uses, has proven, and leaves.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["friction_grip_node = friction_grip.ros.node:main"]},
)
