"""/metrics of the real daemon: what clients did is what it counts, and Prometheus, promtool, the
alert rules and the dashboard can do something with it."""

import json
import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.parse
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "attack"))

from cell import Crcl, Daemon, Modbus  # noqa: E402

BINARIES = os.environ.get("APRSIM_BIN_DIR", str(ROOT / "build" / "release" / "bin"))
PATIENCE = float(os.environ.get("APRSIM_PATIENCE", "1"))
FILES = ROOT / "docker" / "metrics"


def eventually(condition, seconds, what):
    """Waits for a condition; what it returned."""
    deadline = time.monotonic() + seconds * PATIENCE
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            raise AssertionError(f"not within {seconds * PATIENCE:g} s: {what}")
        time.sleep(0.05)


def get(url):
    with urllib.request.urlopen(url, timeout=20 * PATIENCE) as answer:
        return answer.read().decode()


class Cell(unittest.TestCase):
    def setUp(self):
        self.daemon = Daemon(BINARIES)
        self.addCleanup(self.daemon.close)
        self.url = f"http://127.0.0.1:{self.daemon.ports['web']}"

    def metrics(self):
        """Every sample by its name with labels."""
        samples = {}
        for line in get(self.url + "/metrics").splitlines():
            if not line.startswith("#"):
                name, value = line.rsplit(" ", 1)
                self.assertNotIn(name, samples)
                samples[name] = float(value)
        return samples


class Counts(Cell):
    def test_clients(self):
        before = self.metrics()
        crcl = Crcl(self.daemon.ports["crcl.fanuc"])
        for _ in range(20):
            crcl.status()
        modbus = Modbus(self.daemon.ports["modbus"])
        for _ in range(7):
            self.assertEqual(modbus.write_coil(Modbus.STOP, False), 0)
        self.assertNotEqual(modbus.write_coil(0x7777, True), 0)
        for _ in range(3):
            subprocess.run(
                [os.path.join(BINARIES, "aprsim"), "--ports-file", self.daemon.ports_file, "status"],
                check=False, capture_output=True, timeout=60 * PATIENCE,
            )
        with self.assertRaises(urllib.error.HTTPError):
            get(self.url + "/nothing")
        after = self.metrics()

        def more(name):
            return after[name] - before[name]

        self.assertEqual(more('aprsim_requests_total{wire="crcl.fanuc"}'), 20)
        self.assertEqual(more('aprsim_requests_total{wire="crcl.motoman"}'), 0)
        self.assertEqual(more('aprsim_answer_seconds_count{wire="crcl.fanuc"}'), 20)
        self.assertGreater(more('aprsim_answer_seconds_sum{wire="crcl.fanuc"}'), 0)
        self.assertEqual(more('aprsim_requests_total{wire="modbus"}'), 8)
        self.assertEqual(more('aprsim_request_errors_total{wire="modbus"}'), 1)
        self.assertEqual(more('aprsim_answer_seconds_count{wire="modbus"}'), 8)
        self.assertGreaterEqual(more('aprsim_requests_total{wire="grpc"}'), 3)
        self.assertEqual(more('aprsim_request_errors_total{wire="grpc"}'), 0)
        self.assertGreaterEqual(more('aprsim_answer_seconds_count{wire="grpc"}'), 3)
        self.assertEqual(after['aprsim_connections{wire="crcl.fanuc"}'], 1)
        self.assertEqual(more('aprsim_connections_accepted_total{wire="crcl.fanuc"}'), 1)
        # The page that is not there, and the metrics themselves.
        self.assertEqual(more('aprsim_requests_total{wire="web"}'), 2)
        self.assertEqual(more('aprsim_request_errors_total{wire="web"}'), 1)
        self.assertEqual(more('aprsim_answer_seconds_count{wire="web"}'), 2)
        # Bodies on tables are solved, and to the tolerance.
        self.assertGreater(after["aprsim_solver_iterations_total"], 0)
        self.assertLess(after["aprsim_solver_residual_meters_per_second"], 1e-8)
        # Steps go on while they are counted.
        steps = after["aprsim_step_seconds_count"] - before["aprsim_step_seconds_count"]
        simulated = after["aprsim_simulated_seconds"] - before["aprsim_simulated_seconds"]
        self.assertGreater(steps, 0)
        self.assertLess(abs(steps - simulated * 1000), 200)
        self.assertEqual(
            sum(value for name, value in after.items() if name.startswith("aprsim_bodies{")), 28
        )
        crcl.close()
        modbus.close()
        eventually(
            lambda: self.metrics()['aprsim_connections{wire="crcl.fanuc"}'] == 0, 10, "one less"
        )

    def test_health(self):
        self.assertEqual(get(self.url + "/healthz"), "ok\n")
        # On a busy machine the pace may be a problem, which is said as one.
        try:
            self.assertEqual(get(self.url + "/readyz"), "ready\n")
        except urllib.error.HTTPError as refused:
            self.assertEqual(refused.code, 503)
            self.assertIn("pace", refused.read().decode())


class Prometheus(Cell):
    def promtool(self, *arguments, **options):
        done = subprocess.run(
            ["promtool", *arguments], capture_output=True, text=True, timeout=60 * PATIENCE, **options
        )
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def test_promtool_has_nothing_to_say(self):
        self.assertEqual(self.promtool("check", "metrics", input=get(self.url + "/metrics")), "")
        self.promtool("check", "rules", str(FILES / "alerts.yml"))
        self.promtool("check", "config", "--syntax-only", str(FILES / "prometheus.yml"))

    def test_scrapes_and_answers_all_that_rules_and_dashboard_ask(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        folder = tempfile.TemporaryDirectory(prefix="aprsim-prometheus-")
        self.addCleanup(folder.cleanup)
        config = (FILES / "prometheus.yml").read_text(encoding="utf-8")
        config = config.replace("cell:8080", f"127.0.0.1:{self.daemon.ports['web']}")
        config = config.replace("interval: 5s", "interval: 200ms").replace(
            "alerts.yml", str(FILES / "alerts.yml")
        )
        path = pathlib.Path(folder.name) / "prometheus.yml"
        path.write_text(config, encoding="utf-8")
        log = open(pathlib.Path(folder.name) / "log", "w+b")
        self.addCleanup(log.close)
        server = subprocess.Popen(
            ["prometheus", f"--config.file={path}", f"--storage.tsdb.path={folder.name}/data",
             f"--web.listen-address=127.0.0.1:{port}"],
            stdout=log, stderr=log,
        )
        self.addCleanup(server.wait)
        self.addCleanup(server.terminate)

        def ask(expression):
            query = urllib.parse.urlencode({"query": expression})
            try:
                return json.loads(get(f"http://127.0.0.1:{port}/api/v1/query?{query}"))["data"]["result"]
            except urllib.error.HTTPError as refused:
                if refused.code == 503:  # it is starting
                    return []
                raise AssertionError(f"{expression}: {refused.read().decode()}") from refused
            except OSError:
                self.assertIsNone(server.poll(), "Prometheus has ended")
                return []

        eventually(
            lambda: [s["value"][1] for s in ask("up")] == ["1"], 60, "Prometheus scrapes the cell"
        )
        eventually(lambda: ask("rate(aprsim_step_seconds_count[1m])"), 30, "a second scrape")
        served = {name.split("{")[0] for name in self.metrics()}

        dashboard = json.loads((FILES / "dashboard.json").read_text(encoding="utf-8"))
        asked = [t["expr"] for panel in dashboard["panels"] for t in panel["targets"]]
        self.assertGreater(len(asked), 20)
        rules = json.loads(get(f"http://127.0.0.1:{port}/api/v1/rules"))["data"]["groups"][0]["rules"]
        self.assertGreater(len(rules), 8)
        eventually(
            lambda: all(
                rule["health"] == "ok"
                for rule in json.loads(get(f"http://127.0.0.1:{port}/api/v1/rules"))["data"]["groups"][0]["rules"]
            ),
            30, "all rules are evaluated",
        )
        for expression in asked + [rule["query"] for rule in rules]:
            expression = expression.replace("$__rate_interval", "1m")
            for name in re.findall(r"\b(?:aprsim|process)_[a-z_]+", expression):
                self.assertIn(name, served, expression)
            ask(expression)
        # The rules speak up: when the cell has gone there is an alert.
        self.daemon.process.kill()
        eventually(
            lambda: any(
                alert["labels"]["alertname"] == "CellGone"
                for alert in json.loads(get(f"http://127.0.0.1:{port}/api/v1/alerts"))["data"]["alerts"]
            ),
            30, "an alert that the cell has gone",
        )


del Cell

if __name__ == "__main__":
    unittest.main()
