"""Generates aprsim/v1 from the tree's messages when the package is built: by protoc with gRPC's
plugin for Python, as Debian's protobuf-compiler-grpc has it, or else by grpcio-tools."""

import pathlib
import shutil
import subprocess
import sys

from setuptools import setup
from setuptools.command.build_py import build_py

PROTO = pathlib.Path(__file__).resolve().parents[2] / "proto"
FILES = ["geometry", "cell", "faults", "snapshot", "telemetry_service", "control_service"]


def generate(target: pathlib.Path) -> None:
    inputs = [PROTO / "aprsim" / "v1" / f"{name}.proto" for name in FILES]
    missing = [str(path) for path in inputs if not path.exists()]
    if missing:
        raise SystemExit(f"aprsim is built from its tree: {', '.join(missing)} is missing")
    plugin = shutil.which("grpc_python_plugin")
    if shutil.which("protoc") and plugin:
        command = ["protoc", f"--plugin=protoc-gen-grpc_python={plugin}"]
    else:
        command = [sys.executable, "-m", "grpc_tools.protoc"]
    command += [f"-I{PROTO}", f"--python_out={target}", f"--pyi_out={target}"]
    command += [f"--grpc_python_out={target}", *map(str, inputs)]
    if subprocess.run(command, check=False).returncode != 0:
        raise SystemExit(
            "the messages of aprsim cannot be generated: protoc with grpc_python_plugin (Debian: "
            "protobuf-compiler-grpc), or grpcio-tools, is needed"
        )


class Build(build_py):
    def run(self) -> None:
        super().run()
        generate(pathlib.Path(self.build_lib))


setup(cmdclass={"build_py": Build})
