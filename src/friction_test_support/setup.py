"""Packaging of friction_test_support."""

from setuptools import find_packages, setup

package_name = "friction_test_support"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed", "discovery.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
    ],
    install_requires=["setuptools", "hypothesis", "pytest", "pytest-timeout"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    url="https://friction.example.org",
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Support for the tests of the other packages: pytest settings and a DDS client.",
    license="Apache-2.0",
    entry_points={"pytest11": ["friction = friction_test_support.pytest_plugin"]},
)
