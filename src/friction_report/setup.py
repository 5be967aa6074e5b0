"""Packaging of friction_report."""

from setuptools import find_packages, setup

package_name = "friction_report"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed", "web/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
    ],
    install_requires=["setuptools", "matplotlib", "numpy", "rich"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    url="https://friction.example.org",
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="A recorded drive as arrays, as a summary on the terminal, and as an interactive page",
    license="Apache-2.0",
    entry_points={"console_scripts": ["report = friction_report.__main__:main"]},
)
