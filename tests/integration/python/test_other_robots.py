"""Resets of a running cell to scenes with other robots: their sockets close and open."""

import json
import os
import pathlib
import socket
import subprocess
import tempfile
import threading
import unittest

import grpc
import numpy as np
from aprsim import Cell, Daemon, Refused, RobotError, Unreachable
from aprsim.crcl.v1 import robot_service_pb2, robot_service_pb2_grpc
from aprsim.world import World
from running_cell import PATIENCE, await_that

BINARIES = pathlib.Path(os.environ["APRSIM_BIN_DIR"])
ARMS = ("ur5e", "irb120", "panda", "scara")
INIT = (
    b'<?xml version="1.0"?><CRCLCommandInstance xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">'
    b'<CRCLCommand xsi:type="%s"><CommandID>%d</CommandID></CRCLCommand></CRCLCommandInstance>'
)


class Client:
    """A socket that a robot serves, without the library."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=60 * PATIENCE)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def status(self):
        """The answer to a poll over CRCL."""
        self.socket.sendall(INIT % (b"GetStatusType", 1))
        text = b""
        while b"</CRCLStatus>" not in text:
            more = self.socket.recv(65536)
            assert more, "the server has closed"
            text += more
        return text

    def is_closed_cleanly(self):
        """Reads to the end of the connection; a reset raises."""
        while self.socket.recv(65536):
            pass
        return True


class OtherRobotsTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = pathlib.Path(directory.name)

    def start(self, *arguments, scene="aprs", speed="stepped"):
        daemon = Daemon("--no-web", *arguments, scene=scene, speed=speed, start_s=60 * PATIENCE)
        self.addCleanup(daemon.close)
        cell = Cell.connect(daemon.ports_file)
        self.addCleanup(cell.close)
        return daemon, cell

    def ports(self, daemon):
        return json.loads(pathlib.Path(daemon.ports_file).read_text())

    def assert_refused(self, port):
        with self.assertRaises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", port), timeout=60 * PATIENCE)

    def test_old_sockets_close_and_new_ones_open(self):
        daemon, cell = self.start(scene="aprs_2024")
        before = self.ports(daemon)
        roles = ("crcl", "vision", "motion", "state", "gripper")
        names = [f"{role}.{robot}" for role in roles for robot in ("fanuc", "motoman")]
        clients = {name: Client(before[name]) for name in names}
        for client in clients.values():
            self.addCleanup(client.socket.close)
        self.assertIn(b"CRCL_Ready", clients["crcl.fanuc"].status())
        cell.reset(scene="arms")
        # The ports file has the new robots before the reset is confirmed.
        now = self.ports(daemon)
        self.assertEqual(
            {name for name in now if name.startswith("crcl.")}, {f"crcl.{name}" for name in ARMS}
        )
        self.assertFalse([name for name in now if "fanuc" in name or "motoman" in name])
        for name, client in clients.items():
            with self.subTest(name):
                self.assertTrue(client.is_closed_cleanly())
                if before[name] not in now.values():
                    self.assert_refused(before[name])
        for name in ARMS:
            with self.subTest(name):
                robot = cell.robot(name)
                place = robot.tool()
                robot.move_by([0, 0, -0.02])
                np.testing.assert_allclose(robot.tool()[2, 3], place[2, 3] - 0.02, atol=1e-5)
        with Client(now["crcl.scara"]) as client:
            self.assertIn(b"CRCL_Done", client.status())
        with self.assertRaises(Exception):
            cell.robot("fanuc")
        listed = subprocess.run(
            [BINARIES / "aprsim", "status", "--ports-file", str(daemon.ports_file)],
            capture_output=True, text=True, check=True,
        ).stdout
        self.assertIn("scara", listed)
        self.assertNotIn("fanuc", listed)

    def test_a_robot_that_stays_keeps_its_clients(self):
        daemon, cell = self.start()
        before = self.ports(daemon)
        # In the other scene it is the first robot.
        with (
            Client(before["crcl.motoman"]) as staying,
            Client(before["crcl.fanuc"]) as leaving,
            Client(before["vision.motoman"]) as camera,
        ):
            first = staying.status()
            leaving.status()
            for scene, robots in (("motoman_only", {"motoman"}), ("aprs", {"fanuc", "motoman"})):
                cell.reset(scene=scene)
                now = self.ports(daemon)
                self.assertEqual({n[5:] for n in now if n.startswith("crcl.")}, robots)
                self.assertEqual(now["crcl.motoman"], before["crcl.motoman"])
                staying.socket.sendall(INIT % (b"InitCanonType", 7))
                await_that(lambda: cell.step(10) and b"<CommandID>7</CommandID>" in staying.status(),
                           "the command reaches the robot")
                # The joints are those of this robot, at its new index.
                joints = cell.snapshot().robot("motoman").joints_rad
                self.assertEqual(staying.status().count(b"<JointNumber>"), len(joints))
                cell.step(500)
                self.assertTrue(camera.socket.recv(4096))
            self.assertTrue(leaving.is_closed_cleanly())
            self.assertEqual(first.count(b"<JointNumber>"), 7)

    def test_simple_message_comes_and_goes_beside_the_clients_of_crcl(self):
        daemon, cell = self.start()
        before = self.ports(daemon)
        with Client(before["crcl.fanuc"]) as client:
            client.status()
            cell.reset(scene="aprs_2024")
            between = self.ports(daemon)
            self.assertEqual(between["crcl.fanuc"], before["crcl.fanuc"])
            with Client(between["state.fanuc"]) as states:
                self.assertTrue(states.socket.recv(4096))
                cell.reset(scene="aprs")
                self.assertTrue(states.is_closed_cleanly())
            after = self.ports(daemon)
            self.assertEqual(after["crcl.fanuc"], before["crcl.fanuc"])
            self.assertNotIn("state.fanuc", after)
            client.status()

    def test_thirty_resets_to_and_fro_leave_handles_and_memory_flat(self):
        daemon, cell = self.start("--set", "history.minutes=0", "--set", "journal.memory_mb=0")

        def handles():
            return len(os.listdir(f"/proc/{daemon.process.pid}/fd"))

        def threads():
            return len(os.listdir(f"/proc/{daemon.process.pid}/task"))

        def resident_mb():
            with open(f"/proc/{daemon.process.pid}/statm") as statm:
                return int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20

        seen = []
        for i in range(30):
            cell.reset(scene="arms" if i % 2 == 0 else "aprs")
            name = "panda" if i % 2 == 0 else "motoman"
            with Client(self.ports(daemon)[f"crcl.{name}"]) as client:
                client.status()
                cell.step(20)
            if i % 2 == 1:
                await_that(lambda: cell.step(1) is not None, "steps go on")
                seen.append((handles(), threads(), resident_mb()))
        # Connections of the last clients may still be closing.
        self.assertLessEqual(abs(seen[-1][0] - seen[4][0]), 3, seen)
        self.assertEqual(seen[-1][1], seen[4][1], seen)
        self.assertLess(seen[-1][2] - seen[4][2], 15, seen)

    def start_at(self, port, *names, fanuc=0):
        """A daemon with free ports, but for robots that its scene lacks; its ports file."""
        free = ("crcl.ports.motoman", "vision.ports.fanuc", "vision.ports.motoman")
        keys = [f"{key}=0" for key in (*free, "modbus.port", "grpc.port", "cameras.port")]
        keys += [f"crcl.ports.fanuc={fanuc}"]
        keys += [f"crcl.ports.{name}={port}" for name in names]
        file = self.directory / "ports.json"
        command = [BINARIES / "aprsimd", "--scene", "aprs", "--speed", "stepped", "--no-web"]
        command += ["--exit-on-stdin-eof", "--ports-file", file]
        command += [word for key in keys for word in ("--set", key)]
        daemon = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self.addCleanup(daemon.wait, 60 * PATIENCE)
        self.addCleanup(daemon.stdin.close)
        await_that(file.exists, "the daemon listens")
        return file

    def test_a_port_in_use_refuses_the_reset_before_anything_changes(self):
        taken = socket.socket()
        self.addCleanup(taken.close)
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        file = self.start_at(port, "ur5e")
        cell = Cell.connect(file)
        self.addCleanup(cell.close)
        before = cell.snapshot().message.epoch
        with Client(json.loads(file.read_text())["crcl.fanuc"]) as client:
            with self.assertRaisesRegex(Refused, f"crcl.ur5e: .*port {port}.*in use"):
                cell.reset(scene="arms")
            self.assertEqual(cell.snapshot().message.epoch, before)
            self.assertEqual(tuple(cell.snapshot().robots), ("fanuc", "motoman"))
            self.assertIn(b"CRCL", client.status())
        taken.close()
        cell.reset(scene="arms")
        self.assertEqual(json.loads(file.read_text())["crcl.ur5e"], port)
        cell.robot("ur5e").move_by([0, 0, -0.01])

    def test_one_port_for_two_robots_is_refused_although_it_becomes_free(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        cell = Cell.connect(self.start_at(port, "ur5e", "irb120", fanuc=port))
        self.addCleanup(cell.close)
        with Client(port) as client:
            with self.assertRaisesRegex(Refused, f"crcl.ur5e: .*port {port}: crcl.irb120 listens there"):
                cell.reset(scene="arms")
            self.assertIn(b"CRCL", client.status())
        self.assertEqual(tuple(cell.snapshot().robots), ("fanuc", "motoman"))

    def test_a_journal_replays_to_the_same_states_and_replies(self):
        journal = str(self.directory / "run.journal")
        daemon, cell = self.start("--journal", journal)
        cell.robot("fanuc").move_by([0, 0, 0.02])
        cell.save("two")
        for scene, names in (("arms", ("scara", "ur5e")), ("motoman_only", ("motoman",)),
                             ("arms", ("panda",))):
            cell.reset(scene=scene)
            for name in names:
                cell.robot(name).move_by([0, 0, -0.02])
            cell.step(1500)
        cell.load("two")
        cell.step(12_000)
        cell.close()
        daemon.close()
        replayed = subprocess.run([BINARIES / "aprsimd", "--replay", journal, "--json"],
                                  capture_output=True, text=True)
        self.assertEqual(replayed.returncode, 0, replayed.stdout + replayed.stderr)
        found = json.loads(replayed.stdout)
        self.assertTrue(found["same"])
        self.assertGreater(found["replies"], 50)

    def test_saved_states_and_the_past_bring_their_robots_back(self):
        daemon, cell = self.start()
        fanuc = cell.robot("fanuc")
        fanuc.move_by([0, 0, 0.02])
        place = fanuc.tool()
        cell.save("two")
        moment = cell.snapshot()
        cell.reset(scene="arms")
        cell.robot("panda").move_by([0, 0, -0.02])
        past = cell.past(moment.message.step, moment.message.epoch)
        self.assertEqual(tuple(past.robots), ("fanuc", "motoman"))
        cell.load("two")
        self.assertEqual({n for n in self.ports(daemon) if n.startswith("crcl.")},
                         {"crcl.fanuc", "crcl.motoman"})
        self.assertEqual(cell.snapshot().state_hash, moment.state_hash)
        with Cell.connect(daemon.ports_file) as again:
            np.testing.assert_allclose(again.robot("fanuc").tool(), place, atol=1e-6)
            again.robot("fanuc").move_by([0, 0, -0.02])

    def test_sessions_and_streams_of_robots_that_go_end(self):
        daemon, cell = self.start(speed="max")
        with Cell.connect(daemon.ports_file) as other:
            robot = other.robot("fanuc")
            robot.take()
            statuses = self.statuses(daemon, "fanuc")
            self.assertEqual(len(next(statuses).status.joint_statuses.joint_statuses), 6)
            cell.reset(scene="arms")
            with self.assertRaises((RobotError, Unreachable)):
                robot.move_by([0, 0, 0.02])
            with self.assertRaises(grpc.RpcError) as ended:
                for _ in statuses:
                    pass
            self.assertEqual(ended.exception.code(), grpc.StatusCode.UNAVAILABLE)
            # The session of a robot that came is there as soon as the reset is confirmed.
            self.assertEqual(
                len(next(self.statuses(daemon, "scara")).status.joint_statuses.joint_statuses), 4
            )
            with self.assertRaises(grpc.RpcError) as unknown:
                next(self.statuses(daemon, "fanuc"))
            self.assertEqual(unknown.exception.code(), grpc.StatusCode.NOT_FOUND)
            self.assertIn("irb120, panda, scara, ur5e", unknown.exception.details())

    def statuses(self, daemon, robot):
        """Statuses of a robot over gRPC."""
        channel = grpc.insecure_channel(f"127.0.0.1:{self.ports(daemon)['grpc']}")
        self.addCleanup(channel.close)
        return robot_service_pb2_grpc.RobotServiceStub(channel).StreamStatus(
            robot_service_pb2.StreamStatusRequest(options={"robot": robot}, rate_hz=50)
        )

    def test_virtual_time_goes_on_with_the_robots_that_are_there(self):
        daemon, cell = self.start(
            "--time", "virtual", "--pacers", "crcl.fanuc,crcl.motoman", speed="max"
        )

        def awaited():
            return sorted(cell.snapshot().message.virtual_time.awaited)

        def elapsed(client, polls=4):
            """Simulated milliseconds that a client's polls take."""
            client.status()
            before = cell.snapshot().message.step
            for _ in range(polls):
                client.status()
            return cell.snapshot().message.step - before

        self.assertEqual(awaited(), ["crcl.fanuc", "crcl.motoman"])
        with Client(self.ports(daemon)["crcl.motoman"]) as motoman:
            # The other declared robot leaves: time waits for this one alone.
            cell.reset(scene="motoman_only")
            self.assertEqual(elapsed(motoman), 100)
            # None of the declared robots is there: any client paces.
            cell.reset(scene="arms")
            self.assertTrue(motoman.is_closed_cleanly())
        await_that(lambda: awaited() == ["any client"], "time waits for a client")
        await_that(lambda: "crcl.scara" in self.ports(daemon), "the robots' ports are open")
        with Client(self.ports(daemon)["crcl.scara"]) as scara:
            self.assertEqual(elapsed(scara), 100)
            self.assertEqual(list(cell.snapshot().message.virtual_time.pacers), ["crcl.scara"])
        # Both are back, and time waits for both.
        cell.reset(scene="aprs")
        await_that(lambda: awaited() == ["crcl.fanuc", "crcl.motoman"], "time waits for both")
        step = cell.snapshot().message.step
        await_that(lambda: "crcl.motoman" in self.ports(daemon), "the robots' ports are open")
        with Client(self.ports(daemon)["crcl.fanuc"]) as fanuc:

            def poll_twice():
                fanuc.status()
                fanuc.status()
                fanuc.socket.close()

            polls = threading.Thread(target=poll_twice)
            polls.start()
            await_that(lambda: awaited() == ["crcl.motoman"], "time waits for the other one")
            self.assertEqual(cell.snapshot().message.step, step)
            with Client(self.ports(daemon)["crcl.motoman"]) as motoman:
                motoman.status()
                self.assertEqual(cell.snapshot().message.step, step + 25)
                motoman.status()
                self.assertEqual(cell.snapshot().message.step, step + 50)
            polls.join(60 * PATIENCE)
            self.assertFalse(polls.is_alive())
        self.assertTrue(cell.snapshot().message.virtual_time.reproducible)

    def test_a_run_in_virtual_time_over_other_robots_is_the_same_again(self):
        hashes = []
        for _ in range(2):
            daemon, cell = self.start("--time", "virtual", "--pacers", "crcl.fanuc", speed="max")
            with Client(self.ports(daemon)["crcl.fanuc"]) as fanuc:
                fanuc.status()
            cell.reset(seed=3, scene="arms")
            await_that(lambda: "crcl.ur5e" in self.ports(daemon), "the robots' ports are open")
            with Client(self.ports(daemon)["crcl.ur5e"]) as ur5e:
                ur5e.socket.sendall(INIT % (b"InitCanonType", 7))
                for _ in range(40):
                    status = ur5e.status()
                self.assertIn(b"CRCL_Done", status)
                hashes.append((cell.snapshot().message.step, cell.snapshot().state_hash))
        self.assertEqual(hashes[0], hashes[1])

    def test_a_world_in_this_process_takes_other_robots(self):
        with World("aprs", seed=3) as world:
            world.robot("fanuc").move_by([0, 0, 0.02])
            world.keep()
            kept = world.state_hash
            world.reset(seed=5, scene="arms")
            self.assertEqual(len(world.tool_poses), 4)
            for name in ("scara", "ur5e"):
                world.robot(name).move_by([0, 0, -0.02])
            here = world.state_hash
            world.go_back()
            self.assertEqual(world.state_hash, kept)
            self.assertEqual(len(world.tool_poses), 2)
            world.robot("motoman").move_by([0, 0, 0.02])
        daemon, cell = self.start()
        cell.reset(seed=5, scene="arms")
        for name in ("scara", "ur5e"):
            cell.robot(name).move_by([0, 0, -0.02])
        self.assertEqual(cell.snapshot().state_hash, here)


if __name__ == "__main__":
    unittest.main()
