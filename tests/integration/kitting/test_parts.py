"""The kitting controller's parts, each by itself: no daemon."""

import contextlib
import io
import json
import math
import pathlib
import tempfile
import threading
import time
import unittest

import running_cell  # noqa: F401  (finds the controller's modules)

import action_list
import arm
import calibration
import cell as cells
import crcl_robot
import geometry
import order_lines
import orders
import plan
import report
import trays
import vision
import zones
from geometry import Pose2

CELL = cells.read_cell("aprs")
STATUS = (
    b'<?xml version="1.0"?><CRCLStatus><CommandStatus><Name>MoveToType</Name><CommandID>7</CommandID>'
    b"<StatusID>3</StatusID><CommandState>CRCL_Error</CommandState><StateDescription>too far</StateDescription>"
    b"</CommandStatus><JointStatuses><JointStatus><JointNumber>1</JointNumber><JointPosition>12.5"
    b"</JointPosition></JointStatus></JointStatuses><PoseStatus><Pose><Point><X>1</X><Y>2</Y><Z>3</Z></Point>"
    b"<XAxis><I>0</I><J>1</J><K>0</K></XAxis><ZAxis><I>0</I><J>0</J><K>-1</K></ZAxis></Pose></PoseStatus>"
    b'<GripperStatus xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:type="ParallelGripperStatusType">'
    b"<GripperName>g</GripperName><HoldingObject>true</HoldingObject><Separation>7.6</Separation></GripperStatus>"
    b"</CRCLStatus>"
)


def written(text, suffix):
    folder = tempfile.TemporaryDirectory()
    path = pathlib.Path(folder.name) / ("file" + suffix)
    path.write_text(text, encoding="utf-8")
    return folder, path


def sighting(name, x, y, yaw=0.0, flips=0):
    kind = "P" if "part" in name else "KT" if "kit" in name else "PT"
    return vision.Sighting(name, kind, Pose2(x, y, yaw), 6, flips)


def part_in(tray_name, tray_xy, slot_name, yaw=0.0):
    tray = CELL.trays[tray_name]
    slot = next(s for s in tray.slots if s.name == slot_name)
    return sighting(slot.part, *Pose2(*tray_xy, yaw).point(slot.xy_mm))


class GeometryTest(unittest.TestCase):
    def test_hulls_that_cross_have_no_distance(self):
        self.assertEqual(geometry.hull_distance([(0, 0), (2, 2)], [(0, 2), (2, 0)]), 0)

    def test_a_hull_inside_another_has_no_distance(self):
        square = geometry.hull([(0, 0), (10, 0), (10, 10), (0, 10), (5, 5)])
        self.assertEqual(len(square), 4)
        self.assertEqual(geometry.hull_distance(square, [(4, 4)]), 0)

    def test_distance_of_hulls(self):
        square = geometry.hull([(0, 0), (10, 0), (10, 10), (0, 10)])
        self.assertAlmostEqual(geometry.hull_distance(square, [(13, 14), (13, 20)]), 5)

    def test_a_mean_angle_knows_no_seam(self):
        self.assertAlmostEqual(abs(geometry.mean_angle([math.pi - 0.1, -math.pi + 0.1])), math.pi)


class StatusTest(unittest.TestCase):
    def test_reads_what_the_status_says(self):
        status = crcl_robot.read_status(STATUS)
        self.assertEqual(
            (status.command_id, status.state, status.description), (7, "CRCL_Error", "too far")
        )
        self.assertEqual(status.tool_mm, (1, 2, 3))
        self.assertAlmostEqual(status.tool_yaw, math.pi / 2)
        self.assertEqual((status.holding, status.separation_mm), (True, 7.6))

    def test_a_status_may_lack_pose_and_gripper(self):
        text = b"<CRCLStatus><CommandStatus><CommandID>1</CommandID><CommandState>CRCL_Done</CommandState></CommandStatus></CRCLStatus>"
        status = crcl_robot.read_status(text)
        self.assertIsNone(status.tool_mm)
        self.assertIsNone(status.holding)

    def test_other_documents_are_refused(self):
        for document in (
            b"<CRCLStatus>",
            b"<CRCLStatus></CRCLStatus>",
            STATUS.replace(b">7<", b">seven<"),
        ):
            with self.assertRaises(ValueError):
                crcl_robot.read_status(document)


class VisionTest(unittest.TestCase):
    LINE = "sku_part_large_gear,0.10,384.96,-206.83,0.99,P,sku_kit_m2l1_vessel,1.5,579.1,104.2,0.67,KT,"

    def test_reads_objects(self):
        gear, kit = vision.parse_line(self.LINE)
        self.assertEqual(
            (gear.name, gear.kind, gear.pose),
            ("sku_part_large_gear", "P", Pose2(384.96, -206.83, 0.1)),
        )
        self.assertEqual(kit.kind, "KT")

    def test_skips_what_was_not_detected(self):
        line = "sku_part_small_gear,,,,,P,*,0,1,2,0.9,P,sku_part_small_gear,x,1,2,0.9,P,part_small_gear,0,nan,2,0.9,P,"
        self.assertEqual(vision.parse_line(line + self.LINE)[0].name, "sku_part_large_gear")
        self.assertEqual(len(vision.parse_line(line + self.LINE)), 2)

    def test_names_without_sku_mean_the_same(self):
        self.assertEqual(
            vision.parse_line("part_small_gear,0,1,2,1,P,")[0].name, "sku_part_small_gear"
        )

    def frames(self, *places):
        return [
            vision.parse_line("".join(f"part_small_gear,0,{x},0,1,P," for x in frame))
            for frame in places
        ]

    def test_an_object_coasts_over_frames_that_miss_it(self):
        found = vision.merge_frames(self.frames([10], [], [10.2], [], [10.1], []))
        self.assertEqual([(s.seen, round(s.pose.x, 3)) for s in found.sightings], [(3, 10.1)])

    def test_a_ghost_of_one_frame_is_left_out(self):
        found = vision.merge_frames(self.frames([10], [10, 500], [10], [10], [10], [10]))
        self.assertEqual(len(found.sightings), 1)

    def test_moving_parts_are_reported_and_left_out(self):
        found = vision.merge_frames(self.frames([10, 200], [12, 200], [14, 200], [16, 200]))
        self.assertEqual(([s.pose.x for s in found.sightings], found.moving), ([200], 1))

    def test_neighbours_are_not_mixed_up(self):
        found = vision.merge_frames(self.frames([0, 25], [25, 0], [0, 25]))
        self.assertEqual(sorted(s.pose.x for s in found.sightings), [0, 25])

    def test_a_yaw_that_flips_is_that_of_most_frames(self):
        lines = ["sku_kit_m2l1_vessel,1.57,413.6,-106.1,0.6,KT,"] * 2 + [
            "sku_kit_m2l1_vessel,-1.57,415.0,-107.8,0.6,KT,"
        ] * 4
        found = vision.merge_frames([vision.parse_line(line) for line in lines])
        (kit,) = found.sightings
        self.assertEqual(
            (round(kit.pose.yaw, 3), round(kit.pose.x, 1), kit.flips), (-1.57, 415.0, 2)
        )


class AssociationTest(unittest.TestCase):
    def scene(self, *sightings, **options):
        return trays.associate(list(sightings), CELL, **options)

    def contents(self, scene):
        return {s.slot.name: s.content.value for s in scene.trays[0].slots}

    def test_slots_of_a_turned_kit(self):
        yaw, at = math.radians(90), (125.0, -1245.0)
        scene = self.scene(
            sighting("sku_kit_m2l1_vessel", *at, yaw),
            part_in("sku_kit_m2l1_vessel", at, "mg_2", yaw),
        )
        self.assertEqual(self.contents(scene), {"mg_1": "empty", "mg_2": "right", "lg_1": "empty"})
        x, y = scene.trays[0].slot("lg_1").xy
        self.assertAlmostEqual(x, 125 - 7.46)
        self.assertAlmostEqual(y, -1245 + 38.97)

    def test_wrong_and_blocked_slots(self):
        kit = sighting("sku_kit_m2l1_vessel", 0, 0)
        scene = self.scene(
            kit, sighting("sku_part_small_gear", -51, 38), sighting("sku_part_large_gear", 55, 7)
        )
        self.assertEqual(
            self.contents(scene), {"mg_1": "wrong", "mg_2": "empty", "lg_1": "blocked"}
        )

    def test_an_empty_slot_out_of_sight_is_unknown(self):
        scene = self.scene(sighting("sku_kit_m2l1_vessel", 0, 0), sees=lambda xy: xy[0] < 0)
        self.assertEqual(
            self.contents(scene), {"mg_1": "empty", "mg_2": "empty", "lg_1": "unknown"}
        )

    def test_held_part_has_no_place(self):
        scene = self.scene(sighting("sku_part_small_gear", 100, 0), ignored=[(110, 0)])
        self.assertEqual(scene.parts, [])

    def test_parts_tell_which_way_round_a_kit_lies_that_flips(self):
        at = (0.0, 0.0)
        parts = [part_in("sku_kit_m2l1_vessel", at, name, math.pi) for name in ("mg_1", "lg_1")]
        scene = self.scene(sighting("sku_kit_m2l1_vessel", *at, 0.0, flips=2), *parts)
        self.assertEqual(self.contents(scene), {"mg_1": "right", "mg_2": "empty", "lg_1": "right"})

    def test_trays_are_numbered_from_the_robot_on(self):
        near, far = sighting("sku_kit_m2l1_vessel", 300, 0), sighting(
            "sku_kit_m2l1_vessel", -500, 0
        )
        scene = self.scene(far, near)
        self.assertEqual([(t.number, t.pose.x) for t in scene.trays], [(1, 300), (2, -500)])


    def test_trays_keep_their_numbers_from_look_to_look(self):
        # Equally far: who is first is up to the camera's noise.
        def detect(x, *more):
            places = [(x, 100), (300, -100), *more]
            return self.scene(*(sighting("sku_kit_m2l1_vessel", *xy) for xy in places))

        first, second = detect(299.9), detect(300.1, (-200, 50))
        second.number_as(first)
        numbers = [{t.pose.y: t.number for t in scene.trays} for scene in (first, second)]
        self.assertEqual(numbers[1], {**numbers[0], 50: 3})
        self.assertEqual([t.number for t in second.trays], [1, 2, 3])


class PlanTest(unittest.TestCase):
    KIT, VESSEL = (125.0, -1245.0), (335.0, -1020.0)

    def setUp(self):
        self.sightings = [
            sighting("sku_kit_m2l1_vessel", *self.KIT),
            sighting("sku_medium_gear_vessel", *self.VESSEL),
        ]
        self.sightings += [
            part_in("sku_medium_gear_vessel", self.VESSEL, f"slot_{n}") for n in (1, 2)
        ]

    def step(self, wanted, avoided=lambda _: False, reaches=lambda _: True):
        self.scene = trays.associate(self.sightings, CELL)
        tray = self.scene.tray_at("sku_kit_m2l1_vessel", self.KIT, 60)
        kit = orders.Kit(1, "sku_kit_m2l1_vessel", self.KIT, wanted)
        return plan.next_step(self.scene, kit, tray, reaches, avoided)

    def test_takes_the_part_with_the_shortest_way(self):
        step = self.step({"mg_1": "sku_part_medium_gear"})
        self.assertEqual(
            (step.transfer.source.slot.name, step.transfer.target.slot.name), ("slot_1", "mg_1")
        )

    def test_takes_another_part_when_one_has_failed(self):
        first = self.step({"mg_1": "sku_part_medium_gear"}).transfer.source.xy
        step = self.step(
            {"mg_1": "sku_part_medium_gear"}, avoided=lambda xy: geometry.distance(xy, first) < 5
        )
        self.assertEqual(step.transfer.source.slot.name, "slot_2")

    def test_tells_what_is_missing(self):
        step = self.step({"lg_1": "sku_part_large_gear"})
        self.assertEqual(
            (step.transfer, step.missing, step.done), (None, ("sku_part_large_gear",), False)
        )

    def test_tells_which_slot_is_out_of_reach(self):
        self.assertEqual(
            self.step({"mg_1": "sku_part_medium_gear"}, reaches=lambda _: False).stuck, ("mg_1",)
        )

    def test_is_done_when_all_is_as_wanted(self):
        self.sightings.append(part_in("sku_kit_m2l1_vessel", self.KIT, "mg_1"))
        self.assertTrue(self.step({"mg_1": "sku_part_medium_gear", "mg_2": None}).done)

    def test_a_part_that_has_no_business_in_a_kit_goes_back(self):
        self.sightings.append(part_in("sku_kit_m2l1_vessel", self.KIT, "mg_1"))
        step = self.step({"mg_1": None})
        self.assertEqual(
            (step.transfer.source.slot.name, step.transfer.target.slot.name), ("mg_1", "slot_3")
        )

    def test_completed_work_shows_in_the_scene(self):
        transfer = self.step({"mg_1": "sku_part_medium_gear"}).transfer
        self.scene.taken(transfer.part)
        self.assertIs(transfer.source.content, trays.Content.EMPTY)
        self.scene.placed(transfer.part, transfer.target)
        self.assertIs(transfer.target.content, trays.Content.RIGHT)


class BoardTest(unittest.TestCase):
    def setUp(self):
        self.board = orders.Board(CELL)
        kits = [
            sighting("sku_kit_m2l1_vessel", 125, -1245),
            sighting("sku_kit_s2l2_vessel", -170, -580),
        ]
        self.scene = trays.associate(kits, CELL)
        for robot in ("fanuc", "motoman"):
            self.board.set_up(robot, True)
            self.board.see(robot, self.scene)

    def test_each_robot_takes_first_what_only_it_can_do(self):
        self.assertEqual(self.board.claim("fanuc").tray, "sku_kit_m2l1_vessel")
        self.assertEqual(self.board.claim("motoman").tray, "sku_kit_s2l2_vessel")
        self.assertIsNone(self.board.claim("fanuc"))

    def test_an_order_of_a_robot_that_goes_down_is_for_the_other(self):
        kit = self.board.claim("motoman")
        self.board.claim("fanuc")
        self.board.set_up("motoman", False)
        self.assertIs(self.board.claim("fanuc"), kit)
        self.assertFalse(self.board.mine(kit, "motoman"))

    def test_ends_when_nobody_goes_on(self):
        self.assertFalse(self.board.hopeless(0))
        for robot in ("fanuc", "motoman", "fanuc"):
            kit = self.board.claim(robot)
            if kit is not None:
                self.board.give_up(kit, robot, "no part", None, ["sku_part_large_gear"])
        self.assertTrue(self.board.lacks_parts())
        self.board.give_up(self.board.kits[1], "fanuc", "no part", None)
        self.assertTrue(self.board.hopeless(0))
        self.board.belt_moved(100)
        self.assertFalse(self.board.hopeless(0))
        self.assertAlmostEqual(self.board.kits[1].xy[0], -70)
        self.assertAlmostEqual(self.board.kits[0].xy[0], 125)

    def test_a_robot_that_has_not_come_up_yet_is_waited_for(self):
        board = orders.Board(CELL)
        for robot in ("fanuc", "motoman"):
            board.set_up(robot, False)
        board.set_up("motoman", True)
        board.see("motoman", trays.associate([], CELL))
        self.assertFalse(board.hopeless(1000))
        self.assertTrue(board.hopeless(0))
        self.assertEqual(board.unseen(), ["fanuc"])

    def test_a_robot_that_answers_is_waited_for_while_it_finds_out_where_it_stands(self):
        board = self.board
        for robot in ("fanuc", "motoman"):
            board.set_up(robot, True)
            board.set_up(robot, False)
        self.assertTrue(board.hopeless(0))
        board.set_coming("motoman")
        self.assertFalse(board.hopeless(0))
        board.set_up("motoman", False)
        self.assertTrue(board.hopeless(0))

    def test_one_place_is_for_one_robot(self):
        seen = time.monotonic()
        self.assertTrue(self.board.claim_places("fanuc", [(0, 0)], seen))
        self.assertFalse(self.board.claim_places("motoman", [(5, 5)], seen))
        self.board.release_places("fanuc", [(0, 0)])
        self.assertFalse(self.board.claim_places("motoman", [(5, 5)], seen), "it has changed since")
        self.assertTrue(self.board.claim_places("motoman", [(5, 5)], time.monotonic()))

    def test_the_other_way_round_wants_empty_kits(self):
        self.board.next_round()
        self.assertTrue(self.board.emptying)
        self.assertEqual(set(self.board.kits[0].wanted.values()), {None})
        self.board.next_round()
        self.assertEqual(self.board.kits[0].wanted["lg_1"], "sku_part_large_gear")

    def test_progress_counts_what_is_carried_into_kits_and_back(self):
        kit = self.board.claim("fanuc")
        slots = len(kit.wanted)
        self.board.carried(kit, "fanuc")
        told = self.board.progress()
        self.assertEqual(told["placed"], 1)
        mine = next(o for o in told["orders"] if o["name"] == kit.name)
        self.assertEqual((mine["parts"], mine["parts_wanted"]), (1, slots))
        self.assertEqual((mine["state"], mine["done"]), ("open", 0))
        self.board.next_round()
        told = self.board.progress()
        back = next(o for o in told["orders"] if o["name"] == f"{kit.name}, back to the trays")
        self.assertEqual((told["placed"], back["parts"]), (1, 0), "of this round")


class ReportTest(unittest.TestCase):
    def test_progress_is_told_when_it_changes(self):
        out = io.StringIO()
        told = report.Report(json_lines=True)
        with contextlib.redirect_stdout(out):
            for placed in (1, 1, 2):
                told.show_progress({"placed": placed})
            report.Report(quiet=True).show_progress({"placed": 3})
        lines = [json.loads(line) for line in out.getvalue().splitlines()]
        self.assertEqual(lines, [{"progress": {"placed": 1}}, {"progress": {"placed": 2}}])


class OrderLinesTest(unittest.TestCase):
    TABLE, BELT = "sku_kit_m2l1_vessel", "sku_kit_s2l2_vessel"

    def setUp(self):
        self.board = orders.Board(CELL, [], taking_orders=True)
        self.report = report.Report(quiet=True)
        kits = [sighting(self.TABLE, 125, -1245), sighting(self.TABLE, 125, -1030)]
        self.scene = trays.associate(kits, CELL)
        self.board.set_up("fanuc", True)
        self.board.see("fanuc", self.scene)

    def read(self, *lines):
        source = io.StringIO("".join(f"{line}\n" for line in lines))
        order_lines.OrderLines(source, CELL, self.board, self.report).run()

    def test_an_order_is_looked_for_and_taken_on(self):
        self.assertFalse(self.board.needs_detection("fanuc"))
        self.assertIsNone(self.board.claim("fanuc"))
        slots = '{"lg_1": "sku_part_large_gear"}'
        self.read(f'{{"announce": "a", "tray": "{self.TABLE}", "priority": 2, "slots": {slots}}}')
        self.assertTrue(self.board.needs_detection("fanuc"))
        self.board.see("fanuc", self.scene)
        kit = self.board.claim("fanuc")
        self.assertEqual((kit.order, kit.priority), ("a", 2))
        self.assertEqual(kit.wanted, {"lg_1": "sku_part_large_gear"})
        self.assertEqual([k.order for k in self.board.kits], ["a"], "the other tray is nobody's")
        self.assertFalse(self.board.taking_orders, "the input has ended")

    def test_a_job_ends_without_the_input_ending(self):
        source = io.StringIO('{"end": true}\n{"announce": "of the next job"}\n')
        lines = order_lines.OrderLines(source, CELL, self.board, self.report)
        lines.run()
        self.assertTrue(lines.more)
        self.assertFalse(self.board.taking_orders)
        self.assertIn("next job", source.readline(), "it is not read yet")
        ended = order_lines.OrderLines(io.StringIO(""), CELL, self.board, self.report)
        ended.run()
        self.assertFalse(ended.more)

    def test_a_more_urgent_kit_goes_first(self):
        self.read(f'{{"announce": "usual", "tray": "{self.TABLE}"}}')
        self.board.see("fanuc", self.scene)
        usual = self.board.claim("fanuc")
        self.assertFalse(self.board.give_way(usual, "fanuc"))
        self.read(f'{{"announce": "urgent", "tray": "{self.TABLE}", "priority": 1}}')
        self.board.see("fanuc", self.scene)
        self.assertTrue(self.board.give_way(usual, "fanuc"))
        self.assertEqual(self.board.claim("fanuc").order, "urgent")

    def test_a_cancelled_order_is_nobodys(self):
        self.read(f'{{"announce": "a", "tray": "{self.TABLE}", "count": 3}}')
        self.board.see("fanuc", self.scene)
        kit = self.board.claim("fanuc")
        self.read('{"cancel": "a"}')
        self.assertFalse(self.board.mine(kit, "fanuc"))
        self.assertEqual(self.board.kits, [])
        self.board.see("fanuc", self.scene)
        self.assertIsNone(self.board.claim("fanuc"))

    def test_faulty_order_is_reported_with_its_line(self):
        self.read("{", '{"announce": "a", "tray": "bucket"}', "", '{"fetch": "coffee"}')
        told = [e for e in self.report.events if e["event"] == "order_error"]
        texts = [event["text"] for event in told]
        self.assertEqual(len(texts), 3)
        self.assertEqual(self.report.events[-1]["event"], "orders_end")
        for text, begin in zip(texts, ("line 1: ", "line 2.tray: one of ", "line 4: announce or")):
            self.assertTrue(text.startswith(begin), text)


class OrdersFileTest(unittest.TestCase):
    def test_reads_kits(self):
        text = '[[kit]]\ntray = "kit_m2l1_vessel"\ncount = 2\npriority = 3\nslots = {lg_1 = "part_large_gear"}\n'
        folder, path = written(text, ".toml")
        with folder:
            order, again = orders.read_orders(path, CELL)
        self.assertEqual(
            (order.tray, order.wanted, order.priority),
            ("sku_kit_m2l1_vessel", {"lg_1": "sku_part_large_gear"}, 3),
        )
        self.assertEqual(order, again)

    def test_names_the_mistake(self):
        for text, expected in (
            ('[[kit]]\ntray = "box"\n', "kit[0].tray"),
            (
                '[[kit]]\ntray = "kit_m2l1_vessel"\nslots = {xx = "part_large_gear"}\n',
                "kit[0].slots.xx",
            ),
            (
                '[[kit]]\ntray = "kit_m2l1_vessel"\nslots = {mg_1 = "part_large_gear"}\n',
                "kit[0].slots.mg_1",
            ),
            ('[[kit]]\ntray = "kit_m2l1_vessel"\ncolour = 1\n', "kit[0].colour"),
            ('[[kit]]\ntray = "kit_m2l1_vessel"\ncount = 0\n', "count >= 1"),
            ("kit = 3\n", "a list of tables"),
        ):
            folder, path = written(text, ".toml")
            with folder, self.assertRaisesRegex(
                cells.CellError, expected.replace("[", r"\[").replace("]", r"\]")
            ):
                orders.read_orders(path, CELL)

    def test_a_goal_that_is_shown_teaches_orders(self):
        at = (400.0, 0.0)
        shown = [sighting("sku_kit_m2l1_vessel", *at), part_in("sku_kit_m2l1_vessel", at, "lg_1")]
        rows = [f"{s.name},{s.pose.yaw},{s.pose.x},{s.pose.y},0.9,{s.kind}" for s in shown]
        for text in ("name,rotation,x,y,score,type\n" + "\n".join(rows), ",".join(rows) + ","):
            folder, path = written(text, ".csv")
            with folder:
                (order,) = orders.read_orders(path, CELL)
            self.assertEqual(
                (order.tray, order.wanted), ("sku_kit_m2l1_vessel", {"lg_1": "sku_part_large_gear"})
            )

    def test_kits_that_nobody_has_ordered_are_left_alone(self):
        board = orders.Board(
            CELL, [orders.Order("sku_kit_m2l1_vessel", {"lg_1": "sku_part_large_gear"})]
        )
        kits = [
            sighting("sku_kit_m2l1_vessel", 125, -1245),
            sighting("sku_kit_m2l1_vessel", 125, -1030),
        ]
        board.see("fanuc", trays.associate(kits, CELL))
        self.assertEqual(len(board.kits), 1)
        self.assertFalse(board.complete())


class CellFileTest(unittest.TestCase):
    def test_names_file_and_key(self):
        folder, path = written('parts = "none.toml"\n', ".toml")
        with folder, self.assertRaisesRegex(cells.CellError, "none.toml"):
            cells.read_cell(str(path))
        parts = pathlib.Path(cells.__file__).parent / "cells" / "trays_2017.toml"
        folder, path = written(
            f'parts = "{parts}"\nclearance_mm = 1\n[robots.r]\nview_mm = 3\n', ".toml"
        )
        with folder, self.assertRaisesRegex(cells.CellError, r"robots\.r\.view_mm: a list"):
            cells.read_cell(str(path))

    def test_homes_are_clear_of_each_other(self):
        for name in ("aprs", "aprs_2024", "aprs_2025"):
            cell = cells.read_cell(name)
            a, b = ([r.base_mm[:2], r.home_mm] for r in cell.robots.values())
            self.assertGreater(geometry.hull_distance(a, b), cell.clearance_mm)


class CalibrationTest(unittest.TestCase):
    TABLE = "X,Y,Z,Offset_X,Offset_Y,Offset_Z\n0,0,0,10,0,0\n100,0,0,20,-2,0\n"

    def test_is_exact_at_the_points_and_between_them_in_between(self):
        folder, path = written(self.TABLE, ".csv")
        with folder:
            correction = calibration.read_correction(path)
        self.assertEqual(correction.apply((0, 0)), (10, 0))
        self.assertEqual(correction.apply((100, 0)), (120, -2))
        x, y = correction.apply((50, 0))
        self.assertAlmostEqual(x, 65)
        self.assertAlmostEqual(y, -1)
        self.assertLessEqual(correction.apply((1000, 0))[0], 1020)

    def test_four_points_make_a_bilinear_map(self):
        error = lambda x, y: (0.01 * x - 2, 0.02 * y + 1e-5 * x * y)
        points = [(500.0, -300.0), (540.0, 200.0), (720.0, -380.0), (760.0, 170.0)]
        correction = calibration.Correction(tuple((p, error(*p)) for p in points))
        for x, y in (*points, (600.0, 0.0), (650.0, -200.0)):
            corrected = correction.apply((x, y))
            self.assertAlmostEqual(corrected[0], x + error(x, y)[0], places=9)
            self.assertAlmostEqual(corrected[1], y + error(x, y)[1], places=9)
        # On one line there is no such map.
        line = calibration.Correction(tuple(((x, 0.0), (1.0, 2.0)) for x in (0.0, 1.0, 2.0, 3.0)))
        self.assertEqual(line.apply((1.5, 0.0)), (2.5, 2.0))

    def test_other_column_names(self):
        folder, path = written("Xin,Yin,Zin,Offset_X,Offset_Y,Label,\n1,2,3,4,5,a,\n", ".csv")
        with folder:
            self.assertEqual(calibration.read_correction(path).points, (((1, 2), (4, 5)),))

    def test_names_line_and_columns(self):
        for text, expected in (
            (self.TABLE + "1,x,0,0,0,0\n", ":4: four numbers"),
            ("a,b\n", "columns such as"),
        ):
            folder, path = written(text, ".csv")
            with folder, self.assertRaisesRegex(cells.CellError, expected):
                calibration.read_correction(path)


class ActionListTest(unittest.TestCase):
    def read(self, text):
        folder, path = written(text, ".txt")
        with folder:
            return action_list.read_actions(path, CELL)

    def test_reads_both_ways_of_writing(self):
        actions = self.read(
            "(look-for-parts 0 sku_kit_m2l1_vessel=2)\n\n(CHECK_KITS )\n(SET_CORRECTION_MODE true)\n"
            "(place-part empty_slot_1_for_medium_gear_in_kit_m2l1_vessel_2)\n(take-part part_medium_gear_in_pt_3 )\n"
            "(inspect-kit sku_kit_m2l1_vessel 1)\n"
        )
        self.assertEqual(
            [a.name for a in actions][:3], ["look-for-parts", "check-kits", "set-correction-mode"]
        )
        self.assertEqual(actions[0].arguments, ("0", "sku_kit_m2l1_vessel=2"))
        self.assertEqual(actions[3].line, 5)

    def test_names_line_and_what_is_expected(self):
        for text, expected in (
            ("take-part", ":1: an action in parentheses"),
            ("(end-program)\n(jump)", ":2: 'jump': one of"),
            ("(take-part medium_gear_1)", ":1: 'medium_gear_1': a part such as"),
            ("(take-part)", ":1: an argument"),
            ("(place-part empty_slot_1_for_blue_gear_in_kit_m2l1_vessel_1)", "a slot such as"),
            ("(look-for-parts 0 box=2)", "a type and a number"),
            ("(add-kit-to-check sku_kit_m2l1_vessel xx=empty)", "a slot of sku_kit_m2l1_vessel"),
            ("(set-correction-mode maybe)", "true or false"),
        ):
            with self.assertRaisesRegex(cells.CellError, expected):
                self.read(text)


class FingersTest(unittest.TestCase):
    def test_open_fingers_keep_clear_of_a_neighbours_peg(self):
        # Fingers move along the tool's y: with yaw 0 one of them would come down on the neighbour.
        (best, *_) = arm.finger_yaws((0, 0), [(0, 40)], 20, 0.0)
        self.assertGreater(abs(math.sin(best)), 0.5)

    def test_the_wrist_turns_no_more_than_it_must(self):
        self.assertAlmostEqual(arm.finger_yaws((0, 0), [], 20, 0.3)[0], 0.3)


class FacesTest(unittest.TestCase):
    """Parts that are gripped by faces and fit their slots at some yaws only."""

    def setUp(self):
        cell = cells.read_cell("taskboard_keys")
        self.arm = arm.Arm(cell, cell.robots["fanuc"], None, None, None, None, threading.Event())

    def test_the_pads_close_on_faces(self):
        for name, step in (("sku_key_8", math.pi / 2), ("sku_nut_m8", math.pi / 3)):
            yaws = self.arm.take_yaws(name, (400, 100), 0.3, [])
            for yaw in yaws:
                self.assertAlmostEqual(math.remainder(yaw - 0.3, step), 0)
            turns = [abs(geometry.wrapped(yaw - self.arm.neutral_yaw((400, 100)))) for yaw in yaws]
            self.assertEqual(turns, sorted(turns))
            self.assertLessEqual(turns[0], step / 2 + 1e-9)

    def test_the_part_comes_to_a_yaw_at_which_it_fits(self):
        self.arm.grip = math.pi / 2
        for name, turns in (("sku_key_8", 2), ("sku_nut_m8", 6)):
            yaws = self.arm.place_yaws(name, (400, -100), 0.2, [])
            self.assertEqual(len(yaws), turns)
            for yaw in yaws:
                part = yaw - self.arm.grip
                self.assertAlmostEqual(math.remainder(part - 0.2, 2 * math.pi / turns), 0)

    def test_slots_have_yaws(self):
        cell = cells.read_cell("taskboard_keys")
        scene = trays.associate([vision.Sighting("sku_key_board", "KT", Pose2(400, 0, 0.5), 6, 0)], cell)
        slot = scene.trays[0].slot("keyway_8")
        self.assertAlmostEqual(slot.yaw, 0.5 + math.radians(30))

    def test_a_grip_needs_its_turns(self):
        text = "[gears.a]\ndisc_radius_mm = 1\nmass_g = 1\ngrip_deg = [0]\n[trays]\n"
        parts = written(text, ".toml")
        self.addCleanup(parts[0].cleanup)
        folder, path = written(f'parts = "{parts[1]}"\nclearance_mm = 1\nsurfaces = []\n[robots]\n', ".toml")
        self.addCleanup(folder.cleanup)
        with self.assertRaisesRegex(cells.CellError, "gears.a.turns: a whole number is expected"):
            cells.read_cell(str(path))


class SpaceTest(unittest.TestCase):
    def setUp(self):
        self.space = zones.Space(250)
        self.space.hold("a", [(0, 0)])
        self.space.hold("b", [(2000, 0)])

    def test_spaces_keep_their_distance(self):
        self.assertTrue(self.space.try_acquire("a", [(0, 0), (1000, 0)]))
        self.assertFalse(self.space.try_acquire("b", [(2000, 0), (1200, 0)]))
        self.assertTrue(self.space.try_acquire("b", [(2000, 0), (1251, 0)]))

    def test_waiting_robots_are_served_in_order(self):
        self.assertTrue(self.space.try_acquire("a", [(0, 0), (1000, 0)]))
        got = threading.Event()
        waiting = threading.Thread(
            target=lambda: self.space.acquire("b", [(2000, 0), (900, 0)]) and got.set(), daemon=True
        )
        waiting.start()
        running_cell.eventually(
            lambda: not self.space.try_acquire("a", [(0, 0), (1000, 0)]), 5, "b is in the queue"
        )
        self.assertFalse(got.is_set())
        self.space.hold("a", [(0, 0)])
        self.assertTrue(got.wait(5 * running_cell.PATIENCE))

    def test_nobody_waits_for_a_robot_that_is_down(self):
        self.space.try_acquire("a", [(0, 0), (1000, 0)])
        self.space.set_down("a", True)
        self.assertFalse(self.space.acquire("b", [(2000, 0), (900, 0)]))
        self.assertTrue(self.space.acquire("b", [(2000, 0), (1500, 0)]))

    def test_the_belt_runs_only_while_no_arm_is_over_it(self):
        self.assertTrue(self.space.try_acquire("a", [(0, 0)], over_belt=True))
        self.assertFalse(self.space.try_acquire("b", [(2000, 0)], moves_belt=True))
        self.space.hold("a", [(0, 0)])
        self.assertTrue(self.space.try_acquire("b", [(2000, 0)], moves_belt=True))
        self.assertFalse(self.space.try_acquire("a", [(0, 0)], over_belt=True))


if __name__ == "__main__":
    unittest.main()
