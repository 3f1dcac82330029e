"""The package installed by pip, from a copy of the tree, without a network."""

import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from running_cell import PACKAGE, PATIENCE, ROOT


class Install(unittest.TestCase):
    def test_pip_install(self):
        with tempfile.TemporaryDirectory() as folder:
            tree, target = pathlib.Path(folder) / "tree", pathlib.Path(folder) / "site"
            generated = shutil.ignore_patterns("*_pb2*", "build", "*.egg-info", "__pycache__")
            shutil.copytree(PACKAGE, tree / "clients" / "python", ignore=generated)
            shutil.copytree(ROOT / "proto", tree / "proto")
            subprocess.run(
                [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps",
                 "--no-build-isolation", "--disable-pip-version-check", "--root-user-action=ignore",
                 "--target", str(target), str(tree / "clients" / "python")],
                check=True, timeout=100 * PATIENCE,
            )
            shutil.rmtree(tree)
            done = subprocess.run(
                [sys.executable, "-c",
                 "import aprsim, aprsim.datasets, aprsim.envs; from aprsim.v1 import snapshot_pb2; "
                 "print(aprsim.__file__, snapshot_pb2.Snapshot(step=7).step)"],
                env={"PYTHONPATH": str(target), "PATH": "/usr/bin:/bin"}, cwd=folder,
                capture_output=True, text=True, timeout=60 * PATIENCE,
            )
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stdout.split(), [str(target / "aprsim" / "__init__.py"), "7"])
            # Every room of the package is installed.
            rooms = {file.parent.relative_to(PACKAGE) for file in PACKAGE.glob("aprsim/**/__init__.py")}
            installed = {file.parent.relative_to(target) for file in target.glob("aprsim/**/__init__.py")}
            self.assertEqual(installed, rooms)
            for file in ("py.typed", "v1/snapshot_pb2.pyi"):
                self.assertTrue((target / "aprsim" / file).exists(), file)


class Documented(unittest.TestCase):
    DOCUMENTS = ("clients/python/README.md", "docs/python.md")
    LINES = (
        "python3 -m venv --system-site-packages build/venv",
        "build/venv/bin/pip install --no-build-isolation clients/python",
    )

    def test_the_documents_have_the_lines(self):
        block = "".join(f"    {line}\n" for line in self.LINES)
        for document in self.DOCUMENTS:
            self.assertIn(block, (ROOT / document).read_text(encoding="utf-8"), document)

    def test_the_documented_lines_without_a_network(self):
        with tempfile.TemporaryDirectory() as folder:
            tree = pathlib.Path(folder)
            generated = shutil.ignore_patterns("*_pb2*", "build", "*.egg-info", "__pycache__")
            shutil.copytree(PACKAGE, tree / "clients" / "python", ignore=generated)
            shutil.copytree(ROOT / "proto", tree / "proto")
            (tree / "build").mkdir()
            environment = {"PATH": "/usr/bin:/bin", "HOME": folder, "PIP_NO_INDEX": "1"}
            for line in self.LINES:
                done = subprocess.run(
                    line.split(), cwd=tree, env=environment, capture_output=True, text=True,
                    timeout=200 * PATIENCE,
                )
                self.assertEqual(done.returncode, 0, f"{line}: {done.stdout}{done.stderr}")
            done = subprocess.run(
                [tree / "build/venv/bin/python", "-c", "import aprsim.datasets; print(aprsim.__file__)"],
                cwd="/", env=environment, capture_output=True, text=True, timeout=60 * PATIENCE,
            )
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("build/venv/lib", done.stdout)


if __name__ == "__main__":
    unittest.main()
