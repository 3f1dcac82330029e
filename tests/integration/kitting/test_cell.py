"""The kitting controller and the daemon: whole jobs, breakdowns, an interrupted job. The
outcomes are read from the daemon's telemetry, which the controller never sees."""

import json
import pathlib
import signal
import socket
import tempfile
import unittest

from running_cell import BINARIES, ROOT, Controller, Daemon, filled_slots, snapshot

import cell as cells

SPEED = "10"
PLACED_MM = 0.5


class KittingTest(unittest.TestCase):
    def start(self, scene="aprs", cell="aprs"):
        self.cell = cells.read_cell(cell)
        self.daemon = Daemon(BINARIES, "--scene", str(scene), "--speed", SPEED, "--no-web")
        self.addCleanup(self.daemon.close)

    def controller(self, *arguments, ports_file=None):
        controller = Controller(*arguments, ports_file=ports_file or self.daemon.ports_file)
        self.addCleanup(lambda: controller.process.poll() is None and controller.kill())
        return controller

    def assert_kits(self, full=(), empty=(), faults=0):
        """These kits are full, each part of its slot's type and near its centre; nothing is held, no
        part lies beside a slot."""
        state = snapshot(self.daemon)
        self.assertEqual(state["world_fault"], "")
        self.assertEqual(int(state["physics_faults"]), faults)
        self.assertFalse(any(robot["gripper"]["holding"] for robot in state["robots"]))
        kits = filled_slots(state, self.cell)
        for name in full:
            for slot in self.cell.trays["sku_" + name.rsplit("_", 1)[0]].slots:
                found = kits[name][slot.name]
                self.assertIsNotNone(found, f"{slot.name} of {name} is empty")
                self.assertEqual(found[0], slot.part)
                self.assertLess(found[1], PLACED_MM, f"{slot.name} of {name}")
        for name in empty:
            self.assertEqual(set(kits[name].values()), {None}, name)

    def assert_done(self, controller, code=0):
        got, report = controller.wait()
        text = "".join(controller.lines)
        self.assertEqual(got, code, text)
        self.assertNotIn("Traceback", text)
        return report


KITS = ("kit_m2l1_vessel_1", "kit_m2l1_vessel_2", "kit_s2l2_vessel_1", "kit_s2l2_vessel_2")


class WholeJobTest(KittingTest):
    def test_both_robots_fill_all_kits(self):
        self.start()
        report = self.assert_done(self.controller())
        self.assert_kits(full=KITS)
        self.assertTrue(report["complete"])
        by = {
            robot: sum(kit["placed_by"].get(robot, 0) for kit in report["kits"])
            for robot in report["robots"]
        }
        self.assertGreaterEqual(min(by.values()), 4, by)
        self.assertEqual(sum(by.values()), 14)
        self.assertEqual(report["counts"].get("robot_error", 0), 0)
        self.assertLessEqual(report["counts"].get("belt", 0), 1, "one tray is to be brought")


class ForeverTest(KittingTest):
    def test_kits_are_filled_emptied_and_filled_again_and_the_progress_is_told(self):
        self.start()
        controller = self.controller("--forever", "--json")
        for done in ("full", "empty", "full"):
            controller.read_until(f"the kits are as {done} as possible")
        controller.process.send_signal(signal.SIGTERM)
        report = self.assert_done(controller, code=130)
        self.assertEqual(report["rounds"], 3)
        submitted = [e["text"] for e in report["events"] if e["event"] == "submit"]
        self.assertEqual(len(submitted), 3 * len(KITS))
        for text in submitted:
            self.assertRegex(text, ", (full|empty)$")
        told = [json.loads(line) for line in controller.lines]
        progress = [line["progress"] for line in told if "progress" in line]
        self.assertGreater(progress[-1]["placed"], 2 * 14)
        names = {order["name"] for step in progress for order in step["orders"]}
        self.assertTrue(any(name.endswith(", back to the trays") for name in names), names)


class VirtualTimeTest(KittingTest):
    def run_once(self):
        pacers = "crcl.fanuc,crcl.motoman,vision.fanuc,vision.motoman"
        options = ("--time", "virtual", "--pacers", pacers, "--no-web")
        self.cell = cells.read_cell("aprs")
        self.daemon = Daemon(BINARIES, "--scene", "aprs", *options)
        self.addCleanup(self.daemon.close)
        self.assert_done(self.controller("--clock", "polls", "--poll-ms", "25"))
        self.assert_kits(full=KITS)
        state = snapshot(self.daemon)
        self.assertTrue(state["virtual_time"]["reproducible"])
        self.daemon.close()
        return state["step"], state["state_hash"]

    def test_a_whole_job_is_the_same_every_time(self):
        self.assertEqual(self.run_once(), self.run_once())


class RestartTest(KittingTest):
    def test_killed_with_a_part_in_the_hand_and_started_again(self):
        self.start("aprs_2024", "aprs_2024")
        for robot in ("fanuc", "motoman"):
            controller = self.controller("--cell", "aprs_2024")
            # From here on it carries a part.
            controller.read_until(robot, "places it")
            controller.kill()
        report = self.assert_done(self.controller("--cell", "aprs_2024"))
        self.assert_kits(full=KITS)
        self.assertGreaterEqual(report["counts"].get("weighs", 0), 1)


class BreakdownTest(KittingTest):
    def test_the_other_robot_takes_over_what_it_reaches(self):
        # Here the Fanuc sees the belt.
        self.start("aprs_2024", "aprs_2024")
        ports = json.loads(pathlib.Path(self.daemon.ports_file).read_text(encoding="utf-8"))
        with socket.create_server(("127.0.0.1", 0)) as closed:
            ports["crcl.motoman"] = closed.getsockname()[1]
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "ports.json"
            path.write_text(json.dumps(ports), encoding="utf-8")
            arguments = ("--cell", "aprs_2024", "--patience", "1")
            report = self.assert_done(self.controller(*arguments, ports_file=path), code=1)
        self.assert_kits(full=KITS[:3], empty=KITS[3:])
        self.assertEqual([kit["state"] for kit in report["kits"]], ["complete"] * 3)
        self.assertEqual((report["complete"], report["never_up"]), (False, ["motoman"]))
        self.assertEqual(report["counts"]["down"], 1)

    def test_stops_robots_and_belt_when_it_is_interrupted(self):
        self.start()
        controller = self.controller()
        controller.read_until("motoman", "takes sku_part")
        controller.process.send_signal(signal.SIGTERM)
        self.assertEqual(self.assert_done(controller, code=130)["exit_code"], 130)
        states = {robot["action"]["kind"] for robot in snapshot(self.daemon)["robots"]}
        self.assertEqual(states, {"ACTION_KIND_STOP"})


class BeltTest(KittingTest):
    def test_the_belt_brings_what_is_missing(self):
        scenes = ROOT / "world" / "scenes"
        text = (
            (scenes / "aprs.yaml").read_text(encoding="utf-8").replace("types/", f"{scenes}/types/")
        )
        # One tray of large gears before the camera is empty, the other is upstream.
        self.assertIn("xy_m: [0.295, -0.707]", text)
        text = text.replace("xy_m: [0.295, -0.707]", "xy_m: [-0.43, -0.6]")
        begin = text.index("    gears:", text.index("name: large_gear_vessel_3"))
        text = text[:begin] + text[text.index("    reachable_by", begin) :]
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder) / "scene.yaml"
            scene.write_text(text, encoding="utf-8")
            self.start(scene)
        with tempfile.TemporaryDirectory() as folder:
            order = pathlib.Path(folder) / "order.toml"
            order.write_text(
                '[[kit]]\ntray = "kit_s2l2_vessel"\nslots = {lg_1 = "part_large_gear"}\n',
                encoding="utf-8",
            )
            report = self.assert_done(self.controller("--robots", "motoman", "--order", str(order)))
        self.assertGreaterEqual(report["counts"]["belt"], 1)
        self.assertGreater(snapshot(self.daemon)["conveyor"]["travel_m"], 0.2)
        filled = [
            slot
            for kit in filled_slots(snapshot(self.daemon), self.cell).values()
            for slot in kit.values()
            if slot
        ]
        self.assertEqual([part for part, _ in filled], ["sku_part_large_gear"])
        self.assertLess(filled[0][1], PLACED_MM)


class ActionListTest(KittingTest):
    LISTS = {
        "fanuc": "(look-for-parts 1 sku_kit_m2l1_vessel=2)\n(take-part part_large_gear_in_pt_1)\n"
        "(place-part empty_slot_1_for_large_gear_in_kit_m2l1_vessel_1)\n(look-for-parts 2)\n(end-program)\n",
        "motoman": "(look-for-parts 1)\n(take-part part_large_gear_in_pt_1)\n"
        "(place-part empty_slot_1_for_large_gear_in_kit_s2l2_vessel_1)\n"
        "(add-kit-to-check sku_kit_s2l2_vessel kit_s2l2_vessel_lg_1=sku_part_large_gear)\n(check-kits)\n"
        "(clear-kits-to-check)\n(set-correction-mode true)\n"
        "(add-kit-to-check sku_kit_s2l2_vessel kit_s2l2_vessel_sg_2=sku_part_small_gear kit_s2l2_vessel_lg_1=empty)\n"
        "(add-kit-to-check sku_kit_s2l2_vessel kit_s2l2_vessel_lg_1=empty)\n(check-kits)\n",
    }

    def test_both_robots_run_a_list(self):
        self.start()
        with tempfile.TemporaryDirectory() as folder:
            arguments = []
            for robot, text in self.LISTS.items():
                path = pathlib.Path(folder) / f"{robot}.txt"
                path.write_text(text, encoding="utf-8")
                arguments += ["--actions", f"{robot}={path}"]
            report = self.assert_done(self.controller(*arguments))
        self.assertEqual(report["failures"], {"fanuc": [], "motoman": []})
        kits = filled_slots(snapshot(self.daemon), self.cell)
        filled = sorted(slot for kit in kits.values() for slot, content in kit.items() if content)
        # The large gear was carried in, checked, and carried back by the second check.
        self.assertEqual(filled, ["lg_1", "sg_2"])


if __name__ == "__main__":
    unittest.main()
