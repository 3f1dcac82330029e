"""Generates aprsim/v1 and aprsim/crcl/v1 from the tree's messages when the package is built."""

import pathlib
import subprocess

from setuptools import setup
from setuptools.command.build_py import build_py


class Build(build_py):
    """Builds the sources, then the messages."""

    def run(self) -> None:
        super().run()
        generate = pathlib.Path(__file__).resolve().parent / "generate"
        if subprocess.run([str(generate), self.build_lib], check=False).returncode != 0:
            raise SystemExit("the messages of aprsim cannot be generated: see above")


setup(cmdclass={"build_py": Build})
