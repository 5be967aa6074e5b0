"""Packaging of friction_fleet."""

from setuptools import find_packages, setup

package_name = "friction_fleet"

setup(
    name=package_name,
    version="0.2.0",
    packages=find_packages(exclude=["test"]),
    package_data={package_name: ["py.typed", "web/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
    ],
    install_requires=["setuptools", "numpy", "rich", "scipy"],
    extras_require={"test": ["pytest"], "fleet": ["dask[distributed]", "fsspec", "h3", "pyarrow"]},
    zip_safe=True,
    url="https://friction.example.org",
    maintainer="friction developers",
    maintainer_email="developers@friction.example.org",
    description="Many drives of many cars: bags to tables on a cluster, tables to a map of friction",
    license="Apache-2.0",
    entry_points={"console_scripts": ["fleet = friction_fleet.__main__:main"]},
)
