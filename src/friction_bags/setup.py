"""Packaging of friction_bags."""

from glob import glob

from setuptools import find_packages, setup

package_name = "friction_bags"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed", "tutorial/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
        ("share/" + package_name + "/config", glob("config/*.yaml")),
    ],
    install_requires=["setuptools", "numpy", "PyYAML", "rich"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    url="https://friction.example.org",
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Record, replay, repair and offline processing of bags; importers for measured data.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            f"{name} = friction_bags.__main__:executable"
            for name in ("import", "info", "play", "process", "record", "reindex", "tutorial")
        ]
    },
)
