"""What an installation weighs, package by package.

    python -m venv light && light/bin/pip install --no-compile .
    light/bin/python benchmarks/weight.py

Prints a Markdown table of the packages of the environment that runs it, in MB of 10^6 bytes: all
files that an installer wrote for a package, those of them that are Python's bytecode, and which
packages ask for it. Bytecode of what has been imported since is counted, too.
"""

from __future__ import annotations

from collections import defaultdict
from importlib.metadata import Distribution, distributions
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

LIGHT = 1.0  # [MB]: packages below it share a row


def sizes(package: Distribution) -> tuple[float, float]:
    """Return the size of a package's files and of its bytecode, in MB."""
    files = {Path(str(package.locate_file(file))) for file in package.files or ()}
    files |= {code for file in files for code in file.parent.glob("__pycache__/*.pyc")}
    found = {file: file.stat().st_size for file in files if file.is_file()}
    compiled = sum(size for file, size in found.items() if file.suffix == ".pyc")
    return sum(found.values()) / 1e6, compiled / 1e6


def main() -> None:
    """Print the table."""
    asked: dict[str, set[str]] = defaultdict(set)
    packages = {canonicalize_name(package.name): package for package in distributions()}
    for name, package in packages.items():
        for line in package.requires or ():
            requirement = Requirement(line)
            if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
                asked[canonicalize_name(requirement.name)].add(name)
    rows = sorted(((*sizes(package), name) for name, package in packages.items()), reverse=True)
    shown = [row for row in rows if row[0] >= LIGHT]
    print("| package | MB | of it bytecode | asked for by |\n|---|---|---|---|")
    for size, compiled, name in shown:
        print(f"| {name} | {size:.1f} | {compiled:.1f} | {', '.join(sorted(asked[name])) or '–'} |")
    for words, some in (("others", rows[len(shown) :]), ("together", rows)):
        print(f"| {words} | {sum(r[0] for r in some):.0f} | {sum(r[1] for r in some):.0f} | |")


if __name__ == "__main__":
    main()
