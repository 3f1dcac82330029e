"""Tests of the equipment itself, without NIST's controllers."""

import pathlib
import shutil
import subprocess
import tempfile
import types
import unittest

import equipment

PORTS = {"vision.fanuc": 24000, "vision.motoman": 24001, "crcl.fanuc": 24002, "crcl.motoman": 24003}
FOLDERS = ("example_settings", "example_pddl", "netbeans_run_user_home", "linux_netbeans_run_user_home", "CRCLPrograms")


class FrameworkHomeTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="aprsim-clients-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def copy_of(self, name, content):
        """The bytes of a settings file after it has been copied and pointed at the ports."""
        framework = self.folder / "framework"
        for folder in FOLDERS:
            (framework / folder).mkdir(parents=True)
        (framework / "example_settings" / name).write_bytes(content)
        home = equipment.framework_home(types.SimpleNamespace(folder=self.folder, framework=framework), PORTS)
        return (home / "example_settings" / name).read_bytes()

    def test_only_the_keys_that_point_at_the_cell_change(self):
        content = (
            b"# saved on Windows\r\nint port=64444\r\nstartup.forceTorqueSim=true\r\n"
            b"sysQueriesDir=..\\\\..\\\\linux_netbeans_run_user_home\\\\aprsQueries\r\n"
            b"name=caf\xe9\r\nlast=1"
        )
        wanted = content.replace(b"forceTorqueSim=true", b"forceTorqueSim=false")
        self.assertEqual(self.copy_of("fanuc_settings.txt", content), wanted)

    def test_line_ends_stay_where_a_value_changes(self):
        self.assertEqual(
            self.copy_of("motoman_crclSwingClientProperties.txt", b"int port=64445\nother=1\r\n"),
            b"int port=24003\nother=1\r\n",
        )


MAIN = """
public class Main {
  public static void main(String[] arguments) {
    System.out.print("half a line");
    aprsim.Console.say("abort done");
    System.out.println("a whole line");
    aprsim.Console.say("ready");
  }
}
"""


@unittest.skipUnless(shutil.which("javac"), "needs a Java development kit")
class ConsoleTest(unittest.TestCase):
    def test_answers_begin_a_line(self):
        with tempfile.TemporaryDirectory(prefix="aprsim-clients-") as name:
            folder = pathlib.Path(name)
            (folder / "Main.java").write_text(MAIN, encoding="utf-8")
            console = equipment.HERE / "java" / "aprsim" / "Console.java"
            subprocess.run(["javac", "-d", folder, console, folder / "Main.java"], check=True)
            done = subprocess.run(["java", "-cp", folder, "Main"], capture_output=True, text=True, check=True)
        answers = [line for line in done.stdout.splitlines() if line.startswith("@ ")]
        self.assertEqual(answers, ["@ abort done", "@ ready"])


if __name__ == "__main__":
    unittest.main()
