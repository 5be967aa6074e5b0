"""Packaging of friction_bringup."""

from glob import glob

from setuptools import find_packages, setup

package_name = "friction_bringup"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
        ("share/" + package_name + "/config", glob("config/*.*")),
        ("share/" + package_name + "/launch", glob("launch/*.py")),
        ("share/" + package_name + "/layouts", glob("layouts/*")),
    ],
    install_requires=["setuptools", "rich"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    url="https://friction.example.org",
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Starts the friction graph: launch files, parameter files, the demo and its live view",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            f"{name} = friction_bringup.__main__:executable"
            for name in ("analyse", "demo", "doctor", "graph", "monitor", "policies")
        ]
    },
)
