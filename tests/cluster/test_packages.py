"""The image has what the programs need: the package of every shared library that they name is in
docker/runtime-packages.txt."""

from __future__ import annotations

import os
import re
import subprocess
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BINARIES = Path(os.environ.get("APRSIM_BIN_DIR", ROOT / "build/release/bin"))
# Those of the compiler come with any program of Debian's.
OF_THE_BASE = {"libc6", "libgcc-s1", "libstdc++6"}


def run(*line: object) -> str:
    return subprocess.run([str(word) for word in line], capture_output=True, text=True, check=True).stdout


def closure(packages: set[str]) -> set[str]:
    """With what they depend on, as far as that is installed here."""
    known: set[str] = set()
    new = packages
    while new:
        known |= new
        line = ["dpkg-query", "-W", "-f", "${Depends}, ${Pre-Depends}, ", *sorted(new)]
        depends = subprocess.run(line, capture_output=True, text=True).stdout
        new = {word.split()[0].partition(":")[0] for word in re.split(r"[,|]", depends) if word.strip()} - known
    return known


class RuntimePackages(unittest.TestCase):
    def test_every_library_comes_from_one(self) -> None:
        listed = {
            line
            for line in (ROOT / "docker/runtime-packages.txt").read_text().splitlines()
            if line and not line.startswith("#")
        }
        installed = closure(listed)
        found = 0
        for program in ("aprsimd", "aprsim"):
            places = dict(re.findall(r"(\S+) => (/\S+)", run("ldd", BINARIES / program)))
            needed = re.findall(r"\(NEEDED\).*\[(.*)\]", run("readelf", "-d", BINARIES / program))
            for library in needed:
                place = Path(places.get(library, library)).resolve()
                if library.startswith("ld-linux"):
                    continue
                # /lib is /usr/lib, and either may be its name there.
                package = run("dpkg-query", "-S", f"*{str(place).removeprefix('/usr')}").partition(":")[0]
                if package not in OF_THE_BASE:
                    found += 1
                    self.assertIn(package, installed, f"{program} needs {library}")
        self.assertGreater(found, 5)


if __name__ == "__main__":
    unittest.main()
