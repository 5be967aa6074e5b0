"""Packaging of corner_sim."""

from glob import glob

from setuptools import find_packages, setup

package_name = "corner_sim"

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
    description="Plant of the friction graph: braked wheels, their sensors and the truth, at 200 Hz",
    license="Apache-2.0",
    entry_points={"console_scripts": ["corner_sim_node = corner_sim.ros.node:main"]},
)
