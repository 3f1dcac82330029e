"""The image, built by buildah from this build's installation and run: the demo, and one shard of a batch,
which gives what the build itself gives. Takes some minutes and needs root, so it is not part of tests/run:

    docker/install-packages --no-web --only image-packages.txt
    cmake -DAPRSIM_IMAGE_TEST=ON build/release && ctest --test-dir build/release -L image

or, without ctest, APRSIM_BIN_DIR=build/release/bin python3 tests/cluster/test_image.py. Exits with 77 where
there is no buildah, or no root."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BINARIES = Path(os.environ.get("APRSIM_BIN_DIR", ROOT / "build/release/bin"))
STORE = Path(os.environ.get("APRSIM_IMAGE_STORE", ROOT / "build/image"))
SKIPPED = 77
TAG = "localhost/aprsim-test"
BASE = "debian:12-slim"
MOST_MB = 200  # above the base


def skip(why: str) -> None:
    print(f"SKIPPED: {why}", file=sys.stderr)
    sys.exit(SKIPPED)


def run(*line: object, **options: object) -> str:
    done = subprocess.run([str(word) for word in line], capture_output=True, text=True, **options)  # type: ignore[call-overload]
    if done.returncode != 0:
        raise AssertionError(f"{line}: {done.returncode}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return str(done.stdout)


def buildah(*line: object) -> str:
    store = ["--root", STORE / "root", "--runroot", STORE / "run", "--storage-driver", "vfs"]
    return run("buildah", *store, *line, timeout=1200).strip()


class ImageTest(unittest.TestCase):
    container: str

    @classmethod
    def setUpClass(cls) -> None:
        with tempfile.TemporaryDirectory(prefix="aprsim-installed-") as installed:
            run("cmake", "--install", BINARIES.parent, "--prefix", installed, "--strip")
            run(
                ROOT / "docker/build-image", "--with", "buildah", "--installed", installed, "--tag",
                TAG, env={**os.environ, "APRSIM_IMAGE_STORE": str(STORE)}, timeout=1800,
            )  # fmt: skip
        # Engines give more than the chroot would.
        cls.container = buildah("from", "--ulimit", "nofile=8192:8192", "--pull-never", TAG)

    @classmethod
    def tearDownClass(cls) -> None:
        buildah("rm", cls.container)
        buildah("rmi", TAG)

    def inside(self, script: str) -> str:
        """As the image's user, as an engine would run it."""
        return buildah(
            "run", "--isolation", "chroot", "--user", "64444", self.container, "--", "sh", "-ec", script
        )

    def megabytes(self, image: str) -> float:
        container = buildah("from", "--pull-never", image)
        try:
            place = buildah("mount", container)
            return int(run("du", "-sxm", place).split()[0])
        finally:
            buildah("rm", container)

    def test_it_is_small_and_nobody_s_root(self) -> None:
        above = self.megabytes(TAG) - self.megabytes(BASE)
        print(f"{above} MB above the base", file=sys.stderr)
        self.assertLess(above, MOST_MB)
        config = json.loads(buildah("inspect", "--type", "image", TAG))["OCIv1"]["config"]
        self.assertEqual(config["User"], "64444")
        self.assertEqual(config["Entrypoint"][0], "aprsimd")
        self.assertEqual([one for one in config["Env"] if not one.startswith("PATH=")], [])
        self.assertEqual(self.inside("id -u"), "64444")
        for tool in ("g++", "cmake", "npm", "git"):
            self.assertEqual(self.inside(f"command -v {tool} || echo none"), "none")
        self.assertNotIn("not found", self.inside("ldd /opt/aprsim/bin/aprsimd /opt/aprsim/bin/aprsim"))
        self.assertEqual(self.inside("ls /etc/apt/apt.conf.d/99host 2>/dev/null || echo none"), "none")

    def test_the_demo_runs_in_it(self) -> None:
        out = self.inside(
            "aprsimd --any-port --ports-file /tmp/ports.json --speed 5 >/tmp/log 2>&1 & daemon=$!\n"
            "while [ ! -f /tmp/ports.json ]; do kill -0 $daemon || { cat /tmp/log; exit 1; }; sleep 0.1; done\n"
            "aprsim --ports-file /tmp/ports.json demo\n"
            "kill $daemon; wait $daemon"
        )
        self.assertIn("fanuc", out)

    def test_a_shard_of_it_is_that_of_the_build(self) -> None:
        line = "batch pick --seeds 1..6 --shard 1/3 --jobs 1 --journals 0 --out"
        self.inside(f"aprsim {line} /results/shard_1")
        place = Path(buildah("mount", self.container)) / "results/shard_1/report.json"
        with tempfile.TemporaryDirectory() as here:
            run(BINARIES / "aprsim", *line.split(), here)
            self.assertEqual(place.read_text(), (Path(here) / "report.json").read_text())


if __name__ == "__main__":
    if os.getuid() != 0:
        skip("buildah's chroot needs root")
    if shutil.which("buildah") is None:
        skip("no buildah: docker/install-packages --no-web --only image-packages.txt")
    unittest.main()
