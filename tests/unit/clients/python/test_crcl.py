"""CRCL in the Python package: documents beside those of the contract, statuses, the order of both."""

import math
import pathlib
import unittest
import xml.etree.ElementTree as ElementTree

import numpy as np
from aprsim import AprsimError, RobotError, Unreachable, crcl
from aprsim.poses import tool_down

CONTRACT = pathlib.Path(__file__).resolve().parents[3] / "contract" / "crcl"


def shape(element):
    """Tags, attributes and texts; numbers as numbers."""
    text = (element.text or "").strip()
    try:
        text = round(float(text), 9)
    except ValueError:
        pass
    return element.tag, dict(element.attrib), text, [shape(child) for child in element]


def contract_command(name):
    root = ElementTree.parse(CONTRACT / f"command_{name}.xml").getroot()
    return root.find("CRCLCommand")


def status(identifier, state, description=""):
    return (
        f"<CRCLStatus><CommandStatus><CommandID>{identifier}</CommandID><CommandState>CRCL_{state}"
        f"</CommandState><StateDescription>{description}</StateDescription></CommandStatus>"
        "</CRCLStatus>"
    ).encode()


class Documents(unittest.TestCase):
    def assert_like_contract(self, name, command):
        expected = contract_command(name)
        document = crcl.encode(command, int(expected.findtext("CommandID")))
        self.assertEqual(shape(ElementTree.fromstring(document)[0]), shape(expected))

    def test_are_those_of_the_contract(self):
        end = contract_command("move_to").find("EndPosition")
        point, x, z = (
            np.array([float(value.text) for value in end.find(tag)])
            for tag in ("Point", "XAxis", "ZAxis")
        )
        pose = np.eye(4)
        pose[:3, 0], pose[:3, 1], pose[:3, 2], pose[:3, 3] = x, np.cross(z, x), z, point / 1e3
        straight = contract_command("move_to").findtext("MoveStraight") == "true"
        self.assert_like_contract("move_to", crcl.move_to(pose, straight=straight))
        self.assert_like_contract("init_canon", crcl.initialise())
        self.assert_like_contract("end_canon", crcl.end())
        setting = float(contract_command("set_end_effector").findtext("Setting"))
        self.assert_like_contract("set_end_effector", crcl.set_gripper(setting))
        seconds = float(contract_command("dwell").findtext("DwellTime"))
        self.assert_like_contract("dwell", crcl.dwell(seconds))
        condition = contract_command("stop_motion").findtext("StopCondition")
        self.assert_like_contract("stop_motion", crcl.stop(condition))

    def test_numbers_read_back_the_same(self):
        for value in (0.1, 1 / 3, 1e-17, 5e-324, 1.7976931348623157e308):
            document = crcl.encode(crcl.dwell(value), 1)
            self.assertEqual(float(ElementTree.fromstring(document).findtext(".//DwellTime")), value)
            document = crcl.encode(crcl.move_joints({1: -value}, 1), 1)
            self.assertEqual(
                float(ElementTree.fromstring(document).findtext(".//JointPosition")), -value
            )

    def test_numbers_out_of_range_are_refused(self):
        for value in (math.nan, math.inf, -math.inf, -1e-17):
            with self.assertRaisesRegex(AprsimError, "^seconds: .*a number of at least 0 in s is expected"):
                crcl.dwell(value)
        for value in (math.nan, math.inf, -math.inf):
            with self.assertRaisesRegex(AprsimError, r"^positions\[1\]: .*a finite number is expected"):
                crcl.move_joints({1: value}, 1)
        with self.assertRaisesRegex(AprsimError, "4 x 4"):
            crcl.move_to(np.eye(3), straight=True)

    def test_speeds_are_in_the_units_of_the_opening(self):
        document = ElementTree.fromstring(crcl.encode(crcl.set_speed(0.25), 1))
        self.assertEqual(float(document.findtext(".//TransSpeed/Setting")), 250)
        document = ElementTree.fromstring(crcl.encode(crcl.set_turn_speed(math.pi), 1))
        self.assertEqual(float(document.findtext(".//RotSpeed/Setting")), 180)


class Statuses(unittest.TestCase):
    def test_the_contract_s(self):
        read = crcl.decode_status((CONTRACT / "status_full.xml").read_bytes())
        self.assertEqual((read.command_id, read.state), (12, "CRCL_Error"))
        self.assertEqual(read.description, "joint 3 & so on")
        self.assertTrue(read.failed)
        self.assertEqual(read.joints, {1: 10.5, 3: 0.0})
        self.assertTrue(read.holding)
        expected = [[0, 1, 0, 1.5e-3], [1, 0, 0, -2.25e-3], [0, 0, -1, 1e-3 / 3], [0, 0, 0, 1]]
        np.testing.assert_allclose(read.tool_in_reference, expected, atol=1e-15)
        least = crcl.decode_status((CONTRACT / "status_least.xml").read_bytes())
        self.assertIsNone(least.tool_in_reference)
        self.assertIsNone(least.holding)

    def test_other_input(self):
        for document in (b"", b"<a/>", b"<CRCLStatus/>", b"<CRCLStatus", status("x", "Done")):
            with self.assertRaises(ValueError, msg=document):
                crcl.decode_status(document)


class Sessions(unittest.TestCase):
    def setUp(self):
        self.session = crcl.Session("fanuc")

    def test_cuts_the_stream_wherever_it_breaks(self):
        both = status(1, "Working") + b"\0\n" + status(1, "Done")
        for size in (1, 7, 100, len(both)):
            session, read = crcl.Session("fanuc"), []
            for at in range(0, len(both), size):
                found = session.feed(both[at : at + size])
                while found is not None:
                    read.append(found.state)
                    found = session.feed(b"")
            self.assertEqual(read, ["CRCL_Working", "CRCL_Done"])

    def test_ids_go_beyond_what_the_robot_has_seen(self):
        self.session.follow(crcl.decode_status(status(41, "Done")))
        document = ElementTree.fromstring(self.session.begin(crcl.end()))
        self.assertEqual(document.findtext(".//CommandID"), "42")

    def test_tells_when_a_command_is_over(self):
        self.session.begin(crcl.dwell(1))

        def over(*words):
            return self.session.is_over(crcl.decode_status(status(*words)))

        self.assertFalse(over(0, "Done"), "of the command before")
        self.assertFalse(over(1, "Working"))
        self.assertTrue(over(1, "Done"))
        with self.assertRaisesRegex(RobotError, "Dwell: out of reach"):
            over(1, "Error", "out of reach")
        with self.assertRaisesRegex(RobotError, "replaced by command 7"):
            over(7, "Working")

    def test_invalid_status_ends_the_connection(self):
        with self.assertRaises(Unreachable):
            self.session.feed(b"<html></CRCLStatus>")
        with self.assertRaisesRegex(Unreachable, "more than"):
            self.session.feed(b"x" * (1 << 21))


class Motions(unittest.TestCase):
    def test_targets_are_taken_to_the_robot_s_frame(self):
        from aprsim.motions import Motions as RobotMotions
        from aprsim.v1 import cell_pb2

        description = cell_pb2.RobotDescription(name="fanuc")
        description.base_in_world.position_m.x = 1
        description.base_in_world.orientation.w = math.sqrt(0.5)
        description.base_in_world.orientation.z = math.sqrt(0.5)
        description.reference_in_base.orientation.w = 1
        description.reference_in_base.position_m.z = 0.5
        motions = RobotMotions(description)
        pose = motions.target([1, 2, 3], 0.0, "world", None)
        np.testing.assert_allclose(pose[:3, 3], [2, 0, 2.5], atol=1e-12)
        np.testing.assert_allclose(pose[:3, 0], [0, -1, 0], atol=1e-12)
        kept = motions.target([1, 2, 3], None, "robot", tool_down([9, 9, 9], 0.7))
        np.testing.assert_allclose(kept, tool_down([1, 2, 3], 0.7), atol=1e-12)
        for target, yaw, frame, words in (
            ([1, 2], None, "world", "a point of 3 finite numbers in m, or a 4 x 4 pose"),
            ([1, math.nan, 2], 0.0, "world", "finite"),
            (np.eye(4), 0.0, "world", "yaw"),
            ([1, 2, 3], 0.0, "tool", "frame: 'tool'"),
        ):
            with self.assertRaisesRegex(AprsimError, words):
                motions.target(target, yaw, frame, None)


if __name__ == "__main__":
    unittest.main()
