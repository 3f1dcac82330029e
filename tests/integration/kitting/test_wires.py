"""The kitting controller against servers that err, vanish, stall and send what nobody asked for."""

import argparse
import dataclasses
import threading
import unittest

import running_cell
from scripted_servers import CrclServer, ModbusServer, VisionServer

import cell as cells
import conveyor
import crcl_robot
import orders
import plan
import trays
import vision
import wires
import worker
from clock import Clock
from geometry import Pose2
from report import Report
from arm import Arm
from skill_take import Taken, take_part
from zones import Space

CELL = cells.read_cell("aprs")


class CrclTest(unittest.TestCase):
    def robot(self, script=None, **options):
        server = self.enterContext(CrclServer(script))
        robot = crcl_robot.CrclRobot("r", "127.0.0.1", server.port, clock=Clock(0.001), **options)
        self.addCleanup(robot.close)
        robot.connect()
        return robot, server

    def test_a_command_ends_when_its_own_status_is_done(self):
        robot, server = self.robot()
        server.command = 40
        robot.connect()
        status = robot.run("Dwell", "<DwellTime>0</DwellTime>")
        self.assertEqual((status.command_id, server.received), (41, ["Dwell"]))

    def test_an_error_comes_with_the_robots_own_words(self):
        robot, _ = self.robot({"MoveTo": ["error joint 3 at its limit"]})
        with self.assertRaisesRegex(crcl_robot.RobotError, "MoveTo: joint 3 at its limit"):
            robot.move((300, 0, 100), 0, straight=True)

    def test_a_move_that_somebody_else_ends_is_an_error(self):
        robot, _ = self.robot({"MoveTo": ["other"]})
        with self.assertRaisesRegex(crcl_robot.RobotError, "another client commands"):
            robot.move((300, 0, 100), 0, straight=True)

    def test_a_stop_by_another_client_with_an_older_id_is_an_error(self):
        # As NIST's client numbers its stops.
        robot, server = self.robot({"MoveTo": ["working"]})
        robot.run("Dwell", "")

        def stop():
            running_cell.eventually(lambda: server.asked_working > 2, 5, "the move is under way")
            server.command, server.state = server.command - 1, "CRCL_Done"

        threading.Thread(target=stop, daemon=True).start()
        with self.assertRaisesRegex(crcl_robot.RobotError, "another client commands"):
            robot.move((300, 0, 100), 0, straight=True)

    def test_a_command_without_end_is_given_up(self):
        robot, _ = self.robot({"Dwell": ["working"]})
        with self.assertRaisesRegex(crcl_robot.RobotLost, "has not ended within 0.05 s"):
            robot.run("Dwell", "", 0.05)

    def test_a_connection_that_closes_is_lost_and_comes_back(self):
        robot, server = self.robot({"Dwell": ["close"]})
        with self.assertRaises(crcl_robot.RobotLost):
            robot.run("Dwell", "")
        server.state = "CRCL_Done"
        robot.connect()
        robot.run("InitCanon", "")
        self.assertEqual(server.received, ["Dwell", "InitCanon"])

    def test_whoever_waits_can_be_interrupted(self):
        robot, server = self.robot({"Dwell": ["working"]})
        threading.Thread(
            target=lambda: running_cell.eventually(lambda: server.received, 5, "a command")
            and robot.interrupt(),
            daemon=True,
        ).start()
        with self.assertRaises(crcl_robot.Interrupted):
            robot.run("Dwell", "", 30)


class TakeTest(unittest.TestCase):
    PLACE = (250.0, -1000.0)

    def take(self, script=None, holding="false"):
        server = self.enterContext(CrclServer(script))
        server.holding = holding
        robot = CELL.robots["fanuc"]
        crcl = crcl_robot.CrclRobot("fanuc", "127.0.0.1", server.port, clock=Clock(0.001))
        crcl.connect()
        self.addCleanup(crcl.close)
        camera = vision.Camera("127.0.0.1", 1)
        arm = Arm(CELL, robot, crcl, camera, Space(250), Report(quiet=True), threading.Event())
        return take_part(arm, "sku_part_medium_gear", self.PLACE, 17, []), server, arm

    def test_takes_as_the_laboratory_does(self):
        result, server, _ = self.take(holding="true")
        self.assertIs(result, Taken.HELD)
        moves = [kind for kind in server.received if kind in ("MoveTo", "SetEndEffector", "Dwell")]
        self.assertEqual(
            moves,
            [
                "SetEndEffector",
                "Dwell",
                "MoveTo",
                "MoveTo",
                "Dwell",
                "SetEndEffector",
                "Dwell",
                "Dwell",
                "MoveTo",
            ],
        )

    def test_fingers_that_close_on_nothing_open_and_leave(self):
        result, server, _ = self.take()
        self.assertIs(result, Taken.MISSED)
        self.assertEqual(server.received.count("MoveTo"), 3)
        self.assertEqual(server.received.count("SetEndEffector"), 3)

    def test_a_place_out_of_reach_is_refused_with_every_yaw(self):
        result, server, arm = self.take({"MoveTo": ["error out of reach"]})
        self.assertIs(result, Taken.REFUSED)
        self.assertEqual(
            (server.received.count("MoveTo"), server.received.count("InitCanon")), (3, 3)
        )
        self.assertIn("out of reach", arm.report.events[0]["text"])

    def test_another_yaw_helps(self):
        result, server, _ = self.take({"MoveTo": ["error wrist", "done"]}, holding="true")
        self.assertIs(result, Taken.HELD)

    def test_a_stop_on_the_way_down_is_a_failure(self):
        result, _, arm = self.take({"MoveTo": ["done", "error protective stop"]})
        self.assertIs(result, Taken.FAILED)
        self.assertEqual(arm.report.counts["robot_error"], 1)


class HeldTest(unittest.TestCase):
    """A robot that is stopped while it takes a part may have it in its hand."""

    def worker(self, script):
        server = self.enterContext(CrclServer(script))
        server.grips = True
        crcl = crcl_robot.CrclRobot("fanuc", "127.0.0.1", server.port, clock=Clock(0.001))
        crcl.connect()
        self.addCleanup(crcl.close)
        camera = vision.Camera("127.0.0.1", 1)
        arm = Arm(
            CELL,
            CELL.robots["fanuc"],
            crcl,
            camera,
            Space(250),
            Report(quiet=True),
            threading.Event(),
        )
        seen = [
            vision.Sighting("sku_kit_m2l1_vessel", "KT", Pose2(125, -1245), 6, 0),
            vision.Sighting("sku_medium_gear_vessel", "PT", Pose2(335, -1020), 6, 0),
            vision.Sighting("sku_part_medium_gear", "P", Pose2(335 - 37.5, -1020 + 37.5), 6, 0),
        ]
        scene = trays.associate(seen, CELL)
        board = orders.Board(CELL)
        board.set_up("fanuc", True)
        board.see("fanuc", scene)
        kit = board.claim("fanuc")
        tray = scene.tray_at(kit.tray, kit.xy, 60)
        step = plan.next_step(scene, kit, tray, arm.robot.reaches, lambda _: False)
        return worker.Worker(arm, worker.Shop(board, None, [arm])), step.transfer, scene, server

    def test_work_in_hand_is_resumed(self):
        # Approach and descent are done, the retreat is stopped, the way up is free again.
        robot, transfer, scene, server = self.worker(
            {"MoveTo": ["done", "done", "error stopped", "done"]}
        )
        self.assertTrue(robot._carry(transfer, scene))
        self.assertEqual((server.holding, server.received.count("InitCanon")), ("false", 1))
        self.assertIs(transfer.target.content, trays.Content.RIGHT)

    def test_missed_part_is_located_again(self):
        robot, transfer, scene, server = self.worker({"MoveTo": ["done", "error stopped", "done"]})
        self.assertFalse(robot._carry(transfer, scene))
        self.assertIs(transfer.target.content, trays.Content.EMPTY)


class CameraTest(unittest.TestCase):
    def camera(self, lines, **options):
        server = self.enterContext(VisionServer(lines))
        camera = vision.Camera("127.0.0.1", server.port, **options)
        camera.start()
        self.addCleanup(camera.close)
        return camera, server

    @staticmethod
    def lines(*places):
        return [f"sku_part_small_gear,0,{x},{y},0.9,P," for x, y in places]

    def test_looks_in_the_cells_frame(self):
        camera, _ = self.camera(self.lines((10.0, 5.0), (10.1, 5.1)), frame=Pose2(100, -1000, -1.5707963267948966))
        (gear,) = camera.detect(10 * running_cell.PATIENCE).sightings
        self.assertAlmostEqual(gear.pose.x, 105.05, delta=0.06)
        self.assertAlmostEqual(gear.pose.y, -1010.05, delta=0.06)

    def test_waits_for_what_moves(self):
        camera, server = self.camera(self.lines(*((10.0 + 3 * i, 0) for i in range(50))))
        with self.assertRaisesRegex(vision.DetectionError, "everything moves"):
            camera.detect(0.3)
        server.lines = self.lines((7, 0), (7.01, 0))
        self.assertAlmostEqual(
            camera.detect(10 * running_cell.PATIENCE).sightings[0].pose.x, 7, delta=0.1
        )

    def test_a_frame_sent_again_is_no_second_look(self):
        camera, _ = self.camera(self.lines((1, 0)) * 7 + self.lines((2, 0)))
        running_cell.eventually(lambda: camera.frames_read >= 4, 5, "frames")
        with camera._changed:
            frames = [f[0].pose.x for f in camera._frames]
        self.assertNotIn((1, 1), list(zip(frames, frames[1:])))

    def test_a_feed_that_is_not_there_says_so(self):
        with VisionServer([]) as server:
            port = server.port
        camera = vision.Camera("127.0.0.1", port)
        camera.start()
        self.addCleanup(camera.close)
        with self.assertRaisesRegex(vision.DetectionError, f"no feed at 127.0.0.1:{port}|no frame yet"):
            camera.detect(0.1)


class ConveyorTest(unittest.TestCase):
    def step(self, way_mm, **options):
        server = self.enterContext(ModbusServer(**options))
        belt = conveyor.Conveyor(dataclasses.replace(CELL.belt, port=server.port))
        try:
            return belt.step(way_mm, threading.Event()), server
        except conveyor.ConveyorError as error:
            return error, server

    def test_runs_the_belt_there_and_stops_it(self):
        went, server = self.step(100)
        self.assertGreaterEqual(went, 100)
        self.assertEqual(server.written[:3], [(0x8001, 1), (0x8002, 10000), (0x8000, 1)])
        self.assertEqual(server.written[3:], [(0x8000, 0), (0x8002, 0)])

    def test_runs_it_backward(self):
        went, server = self.step(-100)
        self.assertLessEqual(went, -100)
        self.assertEqual(server.written[0], (0x8001, 0))

    def test_a_belt_that_still_runs_is_stopped_and_its_place_told(self):
        server = self.enterContext(ModbusServer())
        server.runs, server.position = True, 31250
        at_mm = conveyor.Conveyor(dataclasses.replace(CELL.belt, port=server.port)).stop()
        self.assertAlmostEqual(at_mm, 312.5)
        self.assertEqual((server.written, server.runs), ([(0x8000, 0)], False))

    def test_a_refusal_is_told_and_the_belt_stopped(self):
        def refuse(function, address, value):
            return [(0, b"\x86\x04")] if (address, value) == (0x8000, 1) else None

        error, server = self.step(100, answer=refuse)
        self.assertIn("device failure", str(error))
        self.assertEqual(server.written[-2:], [(0x8000, 0), (0x8002, 0)])

    def test_a_late_answer_to_an_older_request_is_skipped(self):
        def stray(function, address, value):
            return (
                [(-1, b"\x04\x04\0\0\0\0"), (0, b"\x06\x80\x01\0\x01")]
                if address == 0x8001
                else None
            )

        went, _ = self.step(100, answer=stray)
        self.assertGreaterEqual(went, 100)

    def test_other_protocols_are_refused(self):
        error, _ = self.step(100, answer=lambda *_: [(0, b"\x03\0\0")])
        self.assertIn("function 3 in the answer to 4", str(error))


class HostTest(unittest.TestCase):
    def test_ipv6_hosts_with_and_without_brackets(self):
        for text, host in {"::1": "::1", "[::1]": "::1", "cell": "cell", "127.0.0.1": "127.0.0.1"}.items():
            self.assertEqual(wires.host_of(text), host)
        for text in ("", "[]", "[::1", "::1]"):
            with self.subTest(text), self.assertRaisesRegex(argparse.ArgumentTypeError, "host"):
                wires.host_of(text)


if __name__ == "__main__":
    unittest.main()
