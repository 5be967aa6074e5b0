"""Digest of the code that results are made with: results of other code are other results."""

from collections.abc import Iterable
from hashlib import sha256
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path


def source_digest(packages: Iterable[str], libraries: Iterable[str], files: Iterable[Path] = ()) -> str:
    """Return the digest of the sources and shipped YAML files of packages, of more files, and of libraries.

    Args:
        packages: names.
        libraries: names of distributions, whose versions count.
        files: whose names and contents count.

    Raises:
        OSError: a file cannot be read.
        ModuleNotFoundError: a package is not installed, or, as its PackageNotFoundError, a library.
    """
    found = sha256(" ".join(f"{name} {version(name)}" for name in libraries).encode())
    named = {file.name: file for file in files}
    for package in packages:
        spec = find_spec(package)
        if spec is None or not spec.submodule_search_locations:
            raise ModuleNotFoundError(f"{package} is not an installed package")
        for root in map(Path, spec.submodule_search_locations):
            sources = sorted(each for each in root.rglob("*") if each.suffix in (".py", ".yaml"))
            named |= {f"{package}/{file.relative_to(root)}": file for file in sources}
    for name, file in named.items():
        found.update(f"{name} {sha256(file.read_bytes()).hexdigest()}".encode())
    return found.hexdigest()
