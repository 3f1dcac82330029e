"""The blocking cell: connections, commands, streams, and refusals."""

import asyncio
import math
import os
import pathlib
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
from unittest import mock

import grpc
import numpy as np
from aprsim import (
    AprsimError,
    BadArgument,
    Cell,
    Daemon,
    Happens,
    Refused,
    RobotError,
    TimedOut,
    Unreachable,
    aio,
    crcl,
    faults,
)
from aprsim.binaries import find_binary
from aprsim.channel import channel_options
from aprsim.hosts import is_this_machine
from running_cell import PATIENCE, WithCell, await_that


class CellTest(WithCell):
    def test_steps_answer_with_the_snapshot_after_them(self):
        begin = self.cell.snapshot()
        after = self.cell.step(100)
        self.assertEqual((begin.step, after.step), (0, 100))
        self.assertAlmostEqual(after.sim_time_s, 0.1)
        self.assertEqual(len(after.bodies), len(self.cell.description.bodies))
        self.assertEqual(after.body_poses().shape, (len(after.bodies), 4, 4))
        some = self.cell.step(1, ["robots"])
        self.assertEqual((len(some.bodies), list(some.robots)), (0, ["fanuc", "motoman"]))
        with self.assertRaisesRegex(AprsimError, "steps: 0"):
            self.cell.step(0)
        with self.assertRaises(Refused) as caught:
            self.cell.step(1, ["nothing"])
        self.assertEqual(caught.exception.code, "INVALID_ARGUMENT")

    def test_runs_at_its_speed_and_streams(self):
        self.cell.set_speed(math.inf)
        self.cell.resume()
        self.assertFalse(self.cell.paused)
        with self.assertRaises(Refused) as caught:
            self.cell.step(1)
        self.assertEqual(caught.exception.code, "FAILED_PRECONDITION")
        steps, deadline = [], time.monotonic() + 60 * PATIENCE
        for snapshot in self.cell.stream(hz=100, fields=["step"]):
            steps.append(snapshot.step)
            if len(set(steps)) == 3:
                break
            self.assertLess(time.monotonic(), deadline, "no steps")
        self.assertEqual(steps, sorted(steps))
        self.assertEqual(len(snapshot.robots), 0, "only what was asked for")
        self.assertFalse(self.cell.paused, "which a stream always tells")
        self.cell.pause()
        self.assertTrue(self.cell.paused)
        self.cell.set_speed(1)
        with self.assertRaises(Refused):
            self.cell.set_speed(-1)
        with self.assertRaises(Refused):
            next(self.cell.stream(hz=-1))

    def test_saved_states_go_on_bit_for_bit(self):
        self.cell.set_conveyor(True, forward=True, speed_m_s=0.2)
        self.cell.step(300)
        self.cell.save("here")
        hashes = []
        for _ in range(2):
            self.cell.load("here")
            hashes.append(self.cell.step(500).state_hash)
        self.assertEqual(hashes[0], hashes[1])
        states = {state.name: state for state in self.cell.saved_states()}
        self.assertEqual(states["here"].step, 300)
        self.assertGreater(states["here"].bytes, 1000)
        self.cell.delete_state("here")
        with self.assertRaises(Refused) as caught:
            self.cell.load("here")
        self.assertEqual(caught.exception.code, "NOT_FOUND")

    def test_the_past_is_kept_and_gone_back_to(self):
        self.cell.set_conveyor(True, speed_m_s=0.1)
        seen = [self.cell.step(10) for _ in range(20)]
        span = self.cell.history()[-1]
        self.assertEqual((span.epoch, span.last_step), (seen[-1].message.epoch, seen[-1].step))
        for snapshot in (seen[3], seen[15]):
            past = self.cell.past(snapshot.step)
            self.assertEqual(past.message.state_hash, snapshot.message.state_hash)
        steps = [s.step for s in self.cell.past_range(seen[2].step, seen[6].step, 20)]
        self.assertEqual(steps, [seen[2].step, seen[4].step, seen[6].step])
        mark = self.cell.add_bookmark(seen[5].step, "look here")
        self.assertIn(mark, self.cell.bookmarks())
        self.cell.remove_bookmark(mark.identifier)
        self.assertNotIn(mark, self.cell.bookmarks())
        with self.assertRaises(Refused) as caught:
            self.cell.past(10**9)
        self.assertEqual(caught.exception.code, "NOT_FOUND")
        self.cell.resume_from(seen[9].step)
        self.cell.pause()
        back = self.cell.snapshot()
        self.assertEqual(back.message.epoch, span.epoch + 1)
        self.assertEqual(back.step, seen[9].step)

    def test_the_latest_of_the_run_is_a_journal_that_runs_again(self):
        self.cell.step(2500)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "incident.journal"
            file.write_bytes(self.cell.incident(60))
            again = subprocess.run(
                [find_binary("aprsim"), "replay", file], capture_output=True, text=True,
                timeout=60 * PATIENCE, check=False,
            )
        self.assertEqual(again.returncode, 0, again.stderr)
        with self.assertRaisesRegex(AprsimError, "last_s"):
            self.cell.incident(-1)

    def test_the_belt(self):
        self.cell.set_conveyor(True, forward=False, speed_m_s=0.1)
        belt = self.cell.step(1000).conveyor
        self.assertAlmostEqual(belt.speed_m_s, -0.1, places=6)
        self.assertLess(belt.travel_m, -0.05)
        self.assertTrue(self.cell.set_conveyor(emergency_stop=True).emergency_stop)
        self.assertEqual(self.cell.step(1000).conveyor.speed_m_s, 0)
        self.cell.set_conveyor(emergency_stop=False, fault_reset=True)
        with self.assertRaisesRegex(Refused, "speed"):
            self.cell.set_conveyor(speed_m_s=1000)

    def test_how_moves_regard_obstacles(self):
        self.assertEqual(self.cell.snapshot().robots["fanuc"].planning, "direct")
        self.cell.set_planning("fanuc", "avoid")
        robots = self.cell.step(1).robots
        self.assertEqual([robots[name].planning for name in ("fanuc", "motoman")], ["avoid", "direct"])
        with self.assertRaisesRegex(Refused, "robot"):
            self.cell.set_planning("nobody", "check")
        self.cell.set_planning("fanuc", "direct")

    def test_a_preview_is_the_move_and_changes_nothing(self):
        fanuc = self.cell.robot("fanuc")
        target = fanuc.tool()
        target[:3, 3] += [0.05, 0.1, 0.02]
        early = fanuc.preview(target)
        self.assertFalse(early.possible)
        self.assertIn("not initialized", early.refusal)
        self.assertEqual(len(early.joints_rad), 0)

        fanuc.take()
        before = self.cell.snapshot()
        plan = fanuc.preview(target)
        self.assertTrue(plan.possible, plan.refusal)
        after = self.cell.snapshot()
        self.assertEqual((after.step, after.state_hash), (before.step, before.state_hash))
        self.assertEqual((plan.mode, plan.touch), ("direct", None))
        self.assertGreater(plan.length_m, 0.11)
        self.assertAlmostEqual(plan.times_s[-1], plan.duration_s)
        self.assertEqual(plan.joints_rad.shape, (len(plan.times_s), 6))
        fanuc.move_to(target)
        now = self.cell.snapshot().robots["fanuc"]
        np.testing.assert_allclose(now.joints_rad, plan.joints_rad[-1], atol=1e-4)
        np.testing.assert_allclose(now.tool_in_reference[:3, 3], plan.tool_m[-1], atol=1e-4)

        joints = now.joints_rad + [0.1, 0, 0, 0, 0, 0]
        turn = fanuc.preview_joints(joints, 0.5)
        self.assertGreater(turn.duration_s, 0.2)
        np.testing.assert_allclose(turn.joints_rad[-1], joints, atol=1e-9)
        with self.assertRaisesRegex(Refused, "positions_rad: 5 values, but fanuc has 6"):
            fanuc.preview_joints([0] * 5)
        with self.assertRaisesRegex(Refused, "robot"):
            self.cell.preview("nobody", positions_rad=joints)

    def test_a_preview_tells_what_a_move_would_touch(self):
        fanuc = self.cell.robot("fanuc")
        fanuc.take()
        into = fanuc.tool()
        into[2, 3] = 0.85  # below the top of the table
        direct = fanuc.preview(into, straight=True)
        self.assertTrue(direct.possible, "a direct move is not checked")
        self.assertIsNotNone(direct.touch)
        checked = fanuc.preview(into, straight=True, mode="check")
        self.assertFalse(checked.possible)
        self.assertEqual(checked.touch.other, direct.touch.other)
        self.assertIn(checked.touch.other, checked.refusal)
        self.assertGreater(len(checked.joints_rad), 2)
        self.cell.set_planning("fanuc", "check")
        with self.assertRaises(RobotError) as caught:
            fanuc.move_to(into, straight=True)
        self.assertIn(checked.refusal, str(caught.exception))
        self.cell.set_planning("fanuc", "direct")

    def test_faults_wait_last_and_end(self):
        fault = self.cell.inject_fault(
            "gripper-leak", "fanuc", {"over": 0.5}, when=faults.Reported("now"), duration_s=0.2
        )

        def state(snapshot):
            return {f.id: f.state for f in snapshot.injected_faults}[fault.id]

        pending, active, ended = 1, 2, 3
        self.assertEqual(state(self.cell.step(100)), pending)
        self.cell.report_event("now")
        self.assertEqual(state(self.cell.step(100)), active)
        self.assertEqual(state(self.cell.step(200)), ended)
        other = self.cell.inject_fault("belt-jam")
        self.cell.step(10)
        self.cell.end_fault(other.id)
        self.assertEqual({f.id: f.state for f in self.cell.step(10).injected_faults}[other.id], ended)
        with self.assertRaisesRegex(Refused, "no robot of the cell"):
            self.cell.inject_fault("gripper-leak", "nobody")
        kinds = {kind.name for kind in self.cell.fault_kinds().kinds}
        self.assertGreater(len(kinds), 40)
        self.assertIn("gripper-leak", kinds)

    def test_tells_what_happens(self):
        begin = [event.sequence for event in self.cell.events(past_only=True)][-1]
        self.cell.report_event("order-submitted")
        self.cell.robot("fanuc").dwell(0.01)
        told = list(self.cell.events(begin, past_only=True))
        self.assertEqual([event.sequence for event in told], list(range(begin + 1, begin + 1 + len(told))))
        kinds = [(event.kind, event.text) for event in told]
        self.assertEqual(kinds[0], ("reported", "order-submitted"))
        self.assertIn(("command_done", "dwell"), kinds)
        of_robot = list(self.cell.events(begin, names=["fanuc"], kinds=["command_done"], past_only=True))
        self.assertTrue(of_robot)
        self.assertEqual({(event.kind, event.robot, event.names) for event in of_robot},
                         {("command_done", 0, ("fanuc",))})
        with self.assertRaisesRegex(AprsimError, "'grasp' is none of grasped, "):
            next(self.cell.events(kinds=["grasp"]))
        with self.assertRaisesRegex(Refused, "anew with the daemon"):
            next(self.cell.events(10**9))

    def test_tells_it_as_it_happens(self):
        heard = []
        listener = threading.Thread(
            target=lambda: heard.append(next(self.cell.events(kinds=["reported"])))
        )
        listener.start()
        deadline = time.monotonic() + 60 * PATIENCE
        while listener.is_alive() and time.monotonic() < deadline:
            self.cell.report_event("hello")
            listener.join(0.01)
        self.assertEqual([event.text for event in heard], ["hello"])

    def test_streams_every_step(self):
        stream = self.cell.stream(hz=None, fields=["step", "robots.joints.position_rad"],
                                  entities=["motoman"])
        self.cell.set_speed(math.inf)
        begun = threading.Event()

        def step_until_begun():
            while not begun.wait(0.05):
                self.cell.step(1)

        stepper = threading.Thread(target=step_until_begun)
        stepper.start()
        steps = [next(stream).step]
        begun.set()
        stepper.join()
        deadline = time.monotonic() + 60 * PATIENCE
        for _ in range(30):
            # A cell at full speed may outrun a slow reader, which is another test's matter.
            last = self.cell.step(100).step
            while steps[-1] < last:
                snapshot = next(stream)
                self.assertEqual(len(snapshot.message.robots), 1)
                self.assertEqual(len(snapshot.message.robots[0].joints), 7)
                steps.append(snapshot.step)
                self.assertLess(time.monotonic(), deadline)
        stream.close()
        self.assertEqual(sorted(set(steps)), list(range(steps[0], last + 1)), "none is missing")
        with self.assertRaisesRegex(Refused, "robots.joint' leads nowhere"):
            next(self.cell.stream(fields=["robots.joint"]))
        with self.assertRaisesRegex(Refused, "'nobody'"):
            next(self.cell.stream(entities=["nobody"]))

    def test_runs_until(self):
        self.cell.set_speed(math.inf)
        run = self.cell.run_until(0.25)
        self.assertTrue(run.met)
        self.assertEqual((run.snapshot.step, run.snapshot.paused), (250, True))
        run = self.cell.run_until(max_steps=10)
        self.assertFalse(run.met)
        self.assertEqual(run.snapshot.step, 260)
        run = self.cell.run_until(0.1)
        self.assertEqual((run.met, run.snapshot.step), (True, 260), "which is over")
        self.cell.set_conveyor(True, forward=True, speed_m_s=0.2)
        run = self.cell.run_until(faults.Crossing("belt-travel", above=0.1))
        self.assertTrue(run.met)
        travel = run.snapshot.conveyor.travel_m
        self.assertTrue(0.1 < travel < 0.1003, travel)
        self.cell.inject_fault("protective-stop", "motoman", when=faults.At(2.0))
        run = self.cell.run_until(Happens(["protective_stop"], ["motoman"]), fields=["step"])
        self.assertTrue(run.met)
        self.assertEqual(run.event.names, ("motoman",))
        self.assertEqual((run.event.step, run.snapshot.step), (2001, 2001))
        with self.assertRaisesRegex(Refused, "no quantity"):
            self.cell.run_until(faults.Crossing("nothing", above=1))
        with self.assertRaisesRegex(Refused, "max_steps"):
            self.cell.run_until(max_steps=10_000_001)

    def test_changes_the_scene_while_it_goes_on(self):
        place = np.eye(4)
        place[:3, 3] = (1.0, 0.8, 1.0)
        body = self.cell.spawn("sku_part_large_gear", "spare", place)
        self.assertTrue(np.allclose(body.pose, place))
        self.assertIn("spare", [body.name for body in self.cell.description.bodies])
        self.assertIn("sku_kit_m2l1_vessel", self.cell.description.body_types)
        self.assertIn("spare", self.cell.scene_text())
        place[1, 3] = 0.6
        self.cell.move_body("spare", place)
        self.assertAlmostEqual(self.cell.step(1).bodies["spare"].pose[1, 3], 0.6)
        self.cell.set_scene_value("gear_types.sku_part_large_gear.mass_kg", 0.25)
        self.assertEqual({b.mass_kg for b in self.cell.description.bodies
                          if b.type == "sku_part_large_gear"}, {0.25})
        with self.assertRaisesRegex(Refused, "physics.friction.gear_tray: found -1"):
            self.cell.set_scene_value("physics.friction.gear_tray", -1)
        with self.assertRaisesRegex(Refused, "is no type of gears or trays"):
            self.cell.spawn("nothing", "other", place)
        self.cell.remove_body("spare")
        with self.assertRaisesRegex(Refused, "not in the cell any more"):
            self.cell.remove_body("spare")
        edits = [(e.names, e.text) for e in self.cell.events(0, kinds=["edited"], past_only=True)]
        self.assertEqual(edits[-4:], [(("spare",), "spawned"), (("spare",), "moved"),
                                      ((), "gear_types.sku_part_large_gear.mass_kg = 0.25"),
                                      (("spare",), "removed")])
        self.cell.reset()
        self.assertNotIn("spare", [body.name for body in self.cell.description.bodies])

    def test_resets_to_another_scene(self):
        text = self.cell.scene_text()
        self.cell.reset(scene="aprs_2024")
        self.assertEqual(self.cell.description.scene, "aprs_2024")
        self.cell.step(100)
        self.cell.reset(scene_text=text)
        self.assertEqual(self.cell.description.scene, "sent")
        with self.assertRaisesRegex(Refused, "expected one of"):
            self.cell.reset(scene="nothing")
        self.cell.reset(scene="aprs")
        robot = self.cell.robot("fanuc")
        robot.move_by([0, 0, -0.02])

    def test_a_run_that_is_interrupted_or_given_up(self):
        self.cell.set_speed(1)
        over = threading.Event()

        def pause_until_over():
            while not over.wait(0.2):
                self.cell.pause()

        pauser = threading.Thread(target=pause_until_over)
        pauser.start()
        with self.assertRaisesRegex(Refused, "paused"):
            self.cell.run_until(Happens(["lost"]))
        over.set()
        pauser.join()
        with self.assertRaises(TimedOut):
            self.cell.run_until(Happens(["lost"]), timeout_s=0.3)
        deadline = time.monotonic() + 60 * PATIENCE
        while not self.cell.snapshot().paused:
            self.assertLess(time.monotonic(), deadline, "a run that nobody waits for goes on")

    def test_resets_begin_anew_with_their_seed(self):
        self.cell.step(50)
        receipt = self.cell.reset(seed=9)
        self.assertEqual(receipt.step, 0)
        self.assertEqual(self.cell.snapshot().step, 0)

    def test_threads_may_share_it(self):
        seen, errors = [], []

        def look():
            try:
                for _ in range(20):
                    seen.append(len(self.cell.snapshot().bodies))
            except AprsimError as error:
                errors.append(error)

        threads = [threading.Thread(target=look) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual((len(seen), errors), (80, []))

    def test_nobody_there(self):
        with self.assertRaisesRegex(Unreachable, "127.0.0.1:1"):
            Cell.connect(grpc_port=1)

    def test_a_closed_cell_says_so(self):
        cell = Cell.connect(self.daemon.ports_file)
        errors, begun = [], threading.Barrier(4)

        def wait_in(call):
            begun.wait()
            try:
                call()
            except AprsimError as error:
                errors.append(error)

        robot = cell.robot("fanuc")
        threads = [
            threading.Thread(target=wait_in, args=(call,))
            for call in (
                lambda: list(cell.events()),
                lambda: cell.run_until(Happens(["lost"])),
                lambda: [robot.status() for _ in range(10**9)],
            )
        ]
        for thread in threads:
            thread.start()
        begun.wait()
        await_that(lambda: not self.cell.snapshot().paused, "the run begins")
        cell.close()
        for thread in threads:
            thread.join(60 * PATIENCE)
            self.assertFalse(thread.is_alive())
        self.assertEqual([type(error) for error in errors], [Unreachable] * 3, errors)
        with self.assertRaisesRegex(Unreachable, "is closed"):
            cell.snapshot()
        with self.assertRaisesRegex(Unreachable, "is closed"):
            next(cell.stream())
        with self.assertRaisesRegex(Unreachable, "is closed"):
            cell.robot("motoman")
        await_that(lambda: self.cell.snapshot().paused, "a run without a client pauses the cell")

    def test_an_interrupted_run_leaves_the_cell_paused_and_says_so(self):
        self.cell.pause()

        def interrupt_once_it_runs():
            await_that(lambda: not self.cell.snapshot().paused, "the run begins")
            signal.raise_signal(signal.SIGINT)

        interrupt = threading.Thread(target=interrupt_once_it_runs)
        interrupt.start()
        with self.assertRaises(KeyboardInterrupt):
            self.cell.run_until(Happens(["lost"]))
        interrupt.join()
        self.assertTrue(self.cell.paused)
        self.cell.step(1)
        self.cell.resume()
        with self.assertRaises(TimedOut):
            self.cell.run_until(Happens(["lost"]), timeout_s=0.2)
        self.assertTrue(self.cell.paused)
        self.cell.step(1)
        self.cell.resume()

    def test_errors_name_argument_value_shape_and_unit(self):
        cell, pose = self.cell, np.eye(4)
        turned = np.diag([2.0, 1, 1, 1])
        for words, call in {
            "steps: 1.5, where a whole number": lambda: cell.step(1.5),
            "steps: '3', where a whole number": lambda: cell.step("3"),
            "fields: 'robots', where a sequence of texts": lambda: cell.snapshot("robots"),
            "entities: 5, where a sequence": lambda: cell.snapshot(entities=5),
            "hz: 'x', where a finite number in Hz": lambda: next(cell.stream(hz="x")),
            "kinds: 'grasped', where a sequence": lambda: cell.run_until(Happens("grasped")),
            "until: 'grasped', where a time in s": lambda: cell.run_until("grasped"),
            "until: -1.0, where a number from 0 to 1e": lambda: cell.run_until(-1.0),
            "max_steps: -1, where": lambda: cell.run_until(max_steps=-1),
            "timeout_s: 0, where a number above 0 in s": lambda: cell.run_until(1, timeout_s=0),
            "factor: 'fast', where a finite number": lambda: cell.set_speed("fast"),
            "factor: nan, where": lambda: cell.set_speed(math.nan),
            "seed: -1, where a whole number from 0": lambda: cell.reset(seed=-1),
            "speed_m_s: '1', where a finite number in m/s": lambda: cell.set_conveyor(speed_m_s="1"),
            "run: 1, where True or False": lambda: cell.set_conveyor(1),
            "mode: 'careful', where one of direct, check, avoid":
                lambda: cell.set_planning("fanuc", "careful"),
            "mode: 'wild', where None or one of direct, check, avoid":
                lambda: cell.preview("fanuc", X_RT=pose, mode="wild"),
            "X_RT: either it or positions_rad": lambda: cell.preview("fanuc"),
            "X_RT: a value of shape .3,., where a 4 x 4 pose":
                lambda: cell.preview("fanuc", X_RT=[0, 0, 0]),
            "positions_rad: .*nan": lambda: cell.preview("fanuc", positions_rad=[math.nan]),
            "name: 5, where a text": lambda: cell.save(5),
            "step: -1, where a whole number": lambda: cell.past(-1),
            "stride: 0, where a whole number": lambda: next(cell.past_range(0, 1, stride=0)),
            "X_WB: a value of shape .3,., where a 4 x 4 pose .rotation in .* position in m":
                lambda: cell.spawn("sku_part_large_gear", "x", [0, 0, 0]),
            "X_WB: .*nan.*, where a 4 x 4 pose": lambda: cell.move_body("x", pose * math.nan),
            "X_WB.:3, :3.: .*, where a rotation": lambda: cell.move_body("x", turned),
            "parameters.'over'.: 'x', where a finite number":
                lambda: cell.inject_fault("gripper-leak", "fanuc", {"over": "x"}),
            "when: 5, where a trigger": lambda: cell.inject_fault("belt-jam", when=5),
            "duration_s: -1, where a number from 0": lambda: cell.inject_fault("belt-jam", duration_s=-1),
        }.items():
            with self.subTest(words), self.assertRaisesRegex(BadArgument, words):
                call()
        fanuc = cell.robot("fanuc")
        for words, call in {
            "offset_m: a value of shape .2,., where 3 finite numbers in m": lambda: fanuc.move_by([0, 0]),
            "offset_m: .0, 0, nan., where 3 finite numbers in m": lambda: fanuc.move_by([0, 0, math.nan]),
            "offset_m: 'up', where 3 finite numbers in m": lambda: fanuc.move_by("up"),
            "offset_m: ..1, 2., .3.., where 3 finite": lambda: fanuc.move_by([[1, 2], [3]]),
            "target: a value of shape .4,., where a point of 3 finite numbers in m, or": lambda: fanuc.move_to([1] * 4),
            "target: None, where a point": lambda: fanuc.move_to(None),
            "yaw: 'x', where a finite number in rad": lambda: fanuc.move_to([1, 1, 1], yaw="x"),
            "yaw: not together with": lambda: fanuc.move_to(pose, yaw=1),
            "frame: 'tool', where 'world' or 'robot'": lambda: fanuc.move_by([0, 0, 0], frame="tool"),
            "positions_rad: a value of shape .2,., where 6 finite numbers in rad": lambda: fanuc.move_joints([1, 2]),
            "speed_rad_s: 0, where a number above 0 in rad/s":
                lambda: fanuc.move_joints([0] * 6, speed_rad_s=0),
            "m_s: -1, where a number above 0 in m/s": lambda: fanuc.set_speed(-1),
            "seconds: -1, where a number of at least 0 in s": lambda: fanuc.dwell(-1),
            "setting: 2, where a number from 0 to 1": lambda: crcl.set_gripper(2),
            "timeout_s: 'x', where a number above 0 in s": lambda: fanuc.wait("x"),
            "no command has been started": fanuc.is_done,
        }.items():
            with self.subTest(words), self.assertRaisesRegex(BadArgument, words):
                call()
        self.assertEqual(self.cell.snapshot().step, 0, "nothing has reached the cell")


class ConnectTest(unittest.TestCase):
    """Hosts in every spelling, and the proxy of the environment."""

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(
            "--set", "grpc.address=::1", "--set", "crcl.address=::1", speed="stepped",
            start_s=60 * PATIENCE,
        )
        cls.addClassCleanup(cls.daemon.close)

    def setUp(self):
        # Nobody listens at port 9.
        names = ("http_proxy", "https_proxy", "grpc_proxy")
        self.enterContext(mock.patch.dict(os.environ, dict.fromkeys(names, "http://127.0.0.1:9")))

    def test_ipv6_hosts_with_and_without_brackets(self):
        for host in ("::1", "[::1]", "0:0:0:0:0:0:0:1"):
            with self.subTest(host), Cell.connect(self.daemon.ports_file, host=host) as cell:
                self.assertEqual(len(cell.robot("fanuc").status().joints), 6)

            async def look():
                async with await aio.Cell.connect(self.daemon.ports_file, host=host) as cell:
                    return len((await (await cell.robot("fanuc")).status()).joints)

            with self.subTest("asyncio " + host):
                self.assertEqual(asyncio.run(asyncio.wait_for(look(), 60 * PATIENCE)), 6)

    def test_hosts_that_are_none(self):
        for host in ("127.0.0.1:50051", "[127.0.0.1]", "http://localhost", "", "a b", "::1]"):
            with self.subTest(host), self.assertRaisesRegex(BadArgument, "host: "):
                Cell.connect(self.daemon.ports_file, host=host or " ")
        with self.assertRaisesRegex(BadArgument, "grpc_port: 0, where a whole number from 1 to 65535"):
            Cell.connect(grpc_port=0)

    def test_the_proxy_is_not_for_this_machine(self):
        with Daemon(speed="stepped", start_s=60 * PATIENCE) as daemon:
            for host in (None, "localhost", "127.0.0.1"):
                with self.subTest(host), Cell.connect(daemon.ports_file, host=host) as cell:
                    self.assertEqual(cell.step(1).paused, True)
        self.assertTrue(is_this_machine("127.1.2.3"))
        self.assertTrue(is_this_machine("::1"))
        self.assertTrue(is_this_machine(socket.gethostname()))
        self.assertFalse(is_this_machine("192.0.2.1"), "an address for documents")
        self.assertFalse(is_this_machine("no-such-host.invalid"))

    def test_a_host_elsewhere_is_reached_by_the_proxy(self):
        self.assertIn(("grpc.enable_http_proxy", 0), channel_options("127.0.0.1"))
        self.assertNotIn(("grpc.enable_http_proxy", 0), channel_options("192.0.2.1"))


class AccessTest(unittest.TestCase):
    def test_commands_need_the_token(self):
        with tempfile.TemporaryDirectory() as folder:
            token = pathlib.Path(folder) / "token"
            token.write_text("a-long-secret\n", encoding="utf-8")
            token.chmod(0o600)
            with Daemon("--token-file", str(token), start_s=60 * PATIENCE) as daemon:
                with Cell.connect(daemon.ports_file) as viewer:
                    self.assertEqual(viewer.description.scene, "aprs")
                    with self.assertRaises(Refused) as caught:
                        viewer.pause()
                    self.assertEqual(caught.exception.code, "UNAUTHENTICATED")
                with Cell.connect(daemon.ports_file, token_file=token) as operator:
                    operator.pause()
                    self.assertEqual(operator.step(1).paused, True)

    def test_a_daemon_that_does_not_start_says_why(self):
        with self.assertRaisesRegex(AprsimError, "no_such_scene"):
            Daemon(scene="no_such_scene", start_s=60 * PATIENCE)


if __name__ == "__main__":
    unittest.main()
