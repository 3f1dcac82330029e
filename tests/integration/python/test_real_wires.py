"""The wires of real devices, without a daemon: bytes cut, questions told from commands, times, files."""

import math
import pathlib
import random
import struct
import tempfile
import unittest

import numpy as np
from aprsim import BadArgument
from aprsim.real.base.devices import DeviceLies
from aprsim.real.belts import modbus_wire
from aprsim.real.cameras.part_differences import Planar, Steady, differences
from aprsim.real.cameras.picture_relay import picture_request
from aprsim.real.cameras.vision_lines import Seen, read_line
from aprsim.real.settings import BeltSettings, CameraSettings, RobotSettings
from aprsim.real.settings_file import read_file
from aprsim.real.simple_message import requests
from aprsim.real.simple_message.messages import FANUC, HEADER, MOTOMAN, States, joints_of, message
from aprsim.real.simple_message.reader import SendTimes
from aprsim.real.simple_message.requests import Port, Requests
from running_cell import ROOT

TOPIC = 1


def ten(values):
    return struct.pack(">10f", *values, *[0.0] * (10 - len(values)))


def position(joints):
    return message(10, struct.pack(">i", 0) + ten(joints), TOPIC)


def feedback(joints, group=0, valid=6):
    return message(15, struct.pack(">2if", group, valid, 0) + ten(joints) + ten([]) + ten([]), TOPIC)


STATUS = message(13, struct.pack(">7i", 1, 0, 0, 0, 0, 2, 1), TOPIC)


def cut(cutter, data, chance):
    """All messages, however the bytes are cut."""
    out = []
    while data:
        count = chance.randrange(1, 90)
        out += cutter.add(data[:count])
        data = data[count:]
    return out


class StatesTest(unittest.TestCase):
    def test_messages_are_cut_wherever_the_bytes_are(self):
        chance = random.Random(1)
        for _ in range(20):
            sent = [
                chance.choice([STATUS, position([chance.uniform(-3, 3)]), feedback([chance.uniform(-3, 3)])])
                for _ in range(20)
            ]
            self.assertEqual(cut(States(), b"".join(sent), chance), sent)

    def test_joints_are_those_of_the_model(self):
        chance = random.Random(2)
        for _ in range(50):
            joints = np.array([chance.uniform(-3, 3) for _ in range(6)], dtype=np.float32).astype(float)
            counted = joints.copy()
            counted[2] -= joints[1]  # the Fanuc's third joint is counted against the horizontal
            np.testing.assert_allclose(joints_of(position(counted), FANUC, 6), joints, atol=1e-6)
            seven = [chance.uniform(-3, 3) for _ in range(7)]
            np.testing.assert_allclose(joints_of(feedback(seven), MOTOMAN, 7), seven, atol=1e-6)
        self.assertIsNone(joints_of(STATUS, FANUC, 6))
        self.assertIsNone(joints_of(feedback([0.1]), FANUC, 6))
        self.assertIsNone(joints_of(feedback([0.1], valid=4), MOTOMAN, 7))
        self.assertIsNone(joints_of(feedback([0.1], group=1), MOTOMAN, 7))

    def test_bytes_that_are_no_state_are_lies(self):
        for data in (
            b"HTTP/1.1 200 OK\r\n\r\n", struct.pack(">4i", 11, 10, 1, 0), struct.pack(">4i", 40, 10, 1, 0),
            struct.pack("<4i", 56, 10, 1, 0), struct.pack(">4i", 1 << 20, 10, 1, 0),
        ):
            with self.assertRaises(DeviceLies, msg=data):
                States().add(data)
        for joints in ([math.nan], [math.inf], [0.0] * 8 + [0.1]):
            with self.assertRaisesRegex(DeviceLies, "joints"):
                joints_of(feedback(joints), MOTOMAN, 7)


class SendTimesTest(unittest.TestCase):
    def test_times_are_smoother_than_those_of_arrival(self):
        """Random delays and joined messages: never after the arrival, never back, and with a fraction of
        the delays' scatter."""
        chance = random.Random(3)
        for period_s in (0.024, 0.0255, 0.028):
            times, last_s, seen, estimated = SendTimes(0.024), 0.0, [], []
            at_s = 100.0
            for number in range(2000):
                at_s += period_s
                received_s = max(at_s + chance.expovariate(200), last_s)
                last_s = received_s
                out_s = times.add(received_s)
                self.assertLessEqual(out_s, received_s)
                if number > 100:
                    seen.append(received_s - at_s)
                    self.assertGreaterEqual(out_s, estimated[-1][0] if estimated else 0)
                    estimated.append((out_s, out_s - at_s))
            late = np.array([late for _, late in estimated])
            self.assertLess(late.std(), 0.8 * np.std(seen), period_s)
            self.assertLess(abs(np.median(late)), 0.02, period_s)

    def test_a_silence_begins_anew(self):
        times = SendTimes(0.025)
        self.assertEqual(times.add(1.0), 1.0)
        self.assertEqual(times.add(3.0), 3.0)
        self.assertAlmostEqual(times.add(3.06, 2), 3.052, places=6)


class RequestsTest(unittest.TestCase):
    def motoman_requests(self, chance):
        point = struct.pack(">3if", 0, chance.randrange(9), 7, 0.5) + ten([0.1] * 7) + ten([]) + ten([])
        group = struct.pack(">2if", 0, 7, 0.5) + ten([]) * 3
        return {
            "ping": message(1, b""),
            "point": message(14, point),
            "ready?": message(2001, struct.pack(">3i", 0, 3, 200101) + bytes(40)),
            "queue?": message(2001, struct.pack(">3i", 0, 3, 200102) + bytes(40)),
            "start": message(2001, struct.pack(">3i", 0, 3, 200121) + bytes(40)),
            "stop": message(2001, struct.pack(">3i", 0, 3, 200111) + bytes(40)),
            "bit?": message(2003, struct.pack(">i", 10010)),
            "bit": message(2005, struct.pack(">2i", 10010, 1)),
            "group?": message(2007, struct.pack(">i", 1001)),
            "group": message(2009, struct.pack(">2i", 1001, 1)),
            "register?": message(2012, struct.pack(">i", 3)),
            "register": message(2013, struct.pack(">2i", 3, 1)),
            "points": message(2016, struct.pack(">2i", 1, 4) + group),
            "tool": message(2018, struct.pack(">3i", 0, 2, 5)),
            "dh?": message(2020, b""),
            "unknown": message(2099, bytes(8)),
        }

    def test_requests_are_cut_by_their_types(self):
        chance = random.Random(4)
        for _ in range(20):
            sent = list(self.motoman_requests(chance).values())
            chance.shuffle(sent)
            # The field of the length is wrong in the clients of the laboratory.
            wrong = [
                struct.pack(">i", 136) + one[4:] if one[4:8] == struct.pack(">i", 14) else one for one in sent
            ]
            self.assertEqual(cut(Requests(Port.MOTOMAN), b"".join(wrong), chance), wrong)
        short = message(10, struct.pack(">i", -4) + ten([]))
        long = message(11, struct.pack(">i", 3) + ten([0.1]) + struct.pack(">2f", 0.1, 10))
        sent = [short, long, long, short]
        self.assertEqual(cut(Requests(Port.FANUC_MOTION), b"".join(sent), chance), sent)
        words = [struct.pack(">i", one) for one in (3, 1, 0, 99)]
        self.assertEqual(cut(Requests(Port.FANUC_GRIPPER), b"".join(words), chance), words)

    def test_only_questions_pass(self):
        for name, data in self.motoman_requests(random.Random(5)).items():
            passed = requests.question(Port.MOTOMAN, data)
            if name.endswith("?") or name == "ping":
                self.assertEqual(passed, data, name)
                continue
            self.assertIsNone(passed, name)
            answer, ends = requests.refusal(Port.MOTOMAN, data)
            self.assertFalse(ends)
            if name in ("bit", "group", "register"):
                self.assertEqual(struct.unpack_from(">i", answer, HEADER.size), (1002,))
            elif name == "unknown":
                self.assertEqual(requests.result_of(answer), (3, 3003))
            else:
                self.assertEqual(requests.result_of(answer), (5, 5005), name)
                sequence = struct.unpack_from(">i", answer, HEADER.size + 4)[0]
                self.assertEqual(sequence, struct.unpack_from(
                    ">3i", data, HEADER.size)[2 if name == "tool" else 1], name)  # fmt: skip
        point = message(11, struct.pack(">i", 7) + ten([0.1]) + struct.pack(">2f", 0.1, 10))
        self.assertIsNone(requests.question(Port.FANUC_MOTION, point))
        answer, ends = requests.refusal(Port.FANUC_MOTION, point)
        self.assertEqual(struct.unpack_from(">5i", answer), (56, 10, 3, 2, 7))
        self.assertTrue(ends)
        for word, passes in ((0, False), (1, False), (3, True), (99, False), (-1, False)):
            data = struct.pack(">i", word)
            self.assertEqual(requests.question(Port.FANUC_GRIPPER, data), data if passes else None)

    def test_a_gripper_is_seen(self):
        for address, value, opens in ((10010, 1, True), (10010, 0, None), (10011, 1, False), (10012, 1, None)):
            data = message(2005, struct.pack(">2i", address, value))
            self.assertIs(requests.opens_gripper(Port.MOTOMAN, data), opens)
        for word, opens in ((0, True), (1, False), (3, None)):
            self.assertIs(requests.opens_gripper(Port.FANUC_GRIPPER, struct.pack(">i", word)), opens)


class ModbusTest(unittest.TestCase):
    def frame(self, function, body):
        return struct.pack(">HHHBB", 7, 0, 2 + len(body), 1, function) + body

    def test_only_reads_pass(self):
        chance = random.Random(6)
        for function in range(1, 128):
            frame = self.frame(function, struct.pack(">HH", 0x8000, 3))
            passed = modbus_wire.question(frame)
            self.assertEqual(passed, frame if function in (1, 2, 3, 4) else None, function)
            if passed is None:
                refusal = modbus_wire.refusal(frame)
                self.assertEqual(modbus_wire.Frames().add(refusal), [refusal])
                self.assertEqual(modbus_wire.exception_of(refusal), 1)
        # A read with more behind it is none.
        self.assertIsNone(modbus_wire.question(self.frame(3, bytes(12))))
        frames = [self.frame(chance.randrange(1, 128), bytes(chance.randrange(4, 250))) for _ in range(100)]
        self.assertEqual(cut(modbus_wire.Frames(), b"".join(frames), chance), frames)
        with self.assertRaises(DeviceLies):
            modbus_wire.Frames().add(struct.pack(">HHHB", 1, 5, 6, 1))


class VisionLinesTest(unittest.TestCase):
    def test_lines_are_read_as_they_are_written(self):
        chance = random.Random(7)
        for _ in range(50):
            seen = [
                Seen(
                    chance.choice(["sku_part_large_gear", "sku_kit_s2l2_vessel"]), round(chance.uniform(-3, 3), 4),
                    round(chance.uniform(-1, 1), 6), round(chance.uniform(-1, 1), 6), round(chance.random(), 2),
                    chance.choice(["P", "PT", "KT"]),
                )
                for _ in range(chance.randrange(6))
            ]  # fmt: skip
            line = "".join(
                f"{one.type_name},{one.rotation_rad:.4f},{1e3 * one.x_m:.3f},{1e3 * one.y_m:.3f},"
                f"{one.score:.2f},{one.kind},"
                for one in seen
            )
            for got, one in zip(read_line(line + "\n"), seen, strict=True):
                self.assertEqual((got.type_name, got.kind, got.score), (one.type_name, one.kind, one.score))
                np.testing.assert_allclose(
                    [got.rotation_rad, got.x_m, got.y_m], [one.rotation_rad, one.x_m, one.y_m], atol=1e-9
                )

    def test_empty_slots_are_left_out_and_lies_are_told(self):
        self.assertEqual(read_line("a,,,,,P,b,0.1,2,3,0.5,PT,")[0].type_name, "b")
        self.assertEqual(read_line("\n"), [])
        for line, told in (
            ("a,0,1,2", "4 fields"), ("a,0,x,2,1,P,", "x: 'x'"), ("a,nan,1,2,1,P,", "rotation"),
            ("a,0,99999,2,1,P,", "10000 mm"), ("a,0,1,2,1,Q,", "type 'Q'"), (",0,1,2,1,P,", "object ''"),
        ):
            with self.assertRaisesRegex(DeviceLies, told):
                read_line(line)


class DifferencesTest(unittest.TestCase):
    def cell(self, chance):
        grid = [(0.1 * x, 0.1 * y) for x in range(4) for y in range(4)]
        chance.shuffle(grid)
        return {
            f"body_{number}": (chance.choice(["gear", "tray"]), Planar(*at, chance.uniform(-3, 3)))
            for number, at in enumerate(grid[:10])
        }

    def seen(self, cell, chance):
        kinds = {"gear": "P", "tray": "KT"}
        out = [Seen(kind, at.rotation_rad, at.x_m, at.y_m, 1.0, kinds[kind]) for kind, at in cell.values()]
        chance.shuffle(out)
        return out

    def test_exactly_the_moved_ones_are_found(self):
        chance = random.Random(8)
        for _ in range(100):
            cell = self.cell(chance)
            noisy = {
                name: (kind, Planar(at.x_m + chance.gauss(0, 5e-4), at.y_m, at.rotation_rad + chance.gauss(0, 5e-3)))
                for name, (kind, at) in cell.items()
            }
            self.assertEqual(differences(self.seen(noisy, chance), cell), [])
            name = chance.choice(list(cell))
            kind, at = cell[name]
            noisy[name] = (kind, Planar(at.x_m + 0.02, at.y_m - 0.01, at.rotation_rad))
            (found,) = differences(self.seen(noisy, chance), cell)
            self.assertEqual((found.body, found.type_name), (name, kind))
            self.assertLess(found.place.distance_m(Planar(at.x_m + 0.02, at.y_m - 0.01, 0)), 3e-3)
            # A turn counts for a tray alone.
            noisy[name] = (kind, Planar(at.x_m, at.y_m, at.rotation_rad + 0.2))
            self.assertEqual(len(differences(self.seen(noisy, chance), cell)), kind == "tray")
            # One that the cell lacks has no name.
            del cell[name]
            noisy[name] = (kind, at)
            (found,) = differences(self.seen(noisy, chance), cell)
            self.assertIsNone(found.body)

    def test_a_mistake_of_one_frame_is_left_alone(self):
        cell = {"a": ("gear", Planar(0, 0, 0))}
        away = differences([Seen("gear", 0, 0.05, 0, 1, "P")], cell)
        further = differences([Seen("gear", 0, 0.06, 0, 1, "P")], cell)
        steady = Steady()
        self.assertEqual([len(steady.add(one)) for one in (away, [], away, away, away, further)], [0, 0, 0, 0, 1, 0])


class PictureRequestTest(unittest.TestCase):
    def test_only_pictures_pass(self):
        self.assertEqual(
            picture_request(b"GET /mjpg/video.mjpg HTTP/1.1\r\nHost: a\r\nX: b\r\n\r\n", "cam:80"),
            b"GET /mjpg/video.mjpg HTTP/1.1\r\nHost: cam:80\r\nConnection: close\r\n\r\n",
        )
        for line in (
            b"POST /jpg/image.jpg HTTP/1.1", b"GET /axis-cgi/com/ptz.cgi?pan=1 HTTP/1.1", b"GET /jpg/../a HTTP/1.1",
            b"GET /jpg/image.jpg?a=b HTTP/1.1", b"GET /jpg/image.jpg", b"", b"GET /jpg/a\nX HTTP/1.1",
        ):
            self.assertIsNone(picture_request(line + b"\r\n\r\n", "cam"), line)


class SettingsFileTest(unittest.TestCase):
    def read(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "lab.yaml"
            path.write_text(text, encoding="utf-8")
            return read_file(str(path))

    def test_a_file_has_all_devices(self):
        found = self.read(
            """
allow_commands: true
patience_s: 2
robots:
  fanuc: {source: mirror, address: "192.168.1.10:64444", rate: 20}
  motoman:
    source: shadow
    wire: motoman_fs100
    address: 192.168.1.33:50241
    gripper: 192.168.1.33:50242
    listen: 127.0.0.1:0
    most_mm: 2
conveyor: {source: mirror, address: "192.168.1.50:502", forward: 0}
cameras:
  fanuc: {source: proxy, address: "192.168.1.60:4000", listen: "0.0.0.0:4000"}
"""
        )
        common = {"patience_s": 2, "allow_commands": True}
        self.assertEqual(
            found,
            [
                RobotSettings(
                    name="fanuc", source="mirror", address=("192.168.1.10", 64444), rate=20, **common
                ),
                RobotSettings(
                    name="motoman", source="shadow", wire="motoman_fs100", address=("192.168.1.33", 50241),
                    gripper=("192.168.1.33", 50242), most_mm=2, **common,
                ),
                CameraSettings(
                    name="fanuc", source="proxy", address=("192.168.1.60", 4000), listen=("0.0.0.0", 4000), **common
                ),
                BeltSettings(source="mirror", address=("192.168.1.50", 502), forward=0, **common),
            ],
        )  # fmt: skip
        documented = (ROOT / "docs" / "real.md").read_text(encoding="utf-8")
        example = documented.partition("```yaml\n")[2].partition("```")[0]
        self.assertEqual([type(one) for one in self.read(example)], [type(one) for one in found])
        self.assertFalse(self.read('conveyor: {source: proxy, address: "a:1"}')[0].allow_commands)

    def test_errors_name_file_line_key_and_the_nearest_key(self):
        robot = 'robots:\n  fanuc:\n    source: mirror\n    address: "a:1"\n'
        for text, told in (
            ("", "lab.yaml: it is empty"), ("- a", "lab.yaml:1: the file: keys and values"),
            ("robots:", "lab.yaml:1: robots: keys and values"), ("robots: {}", "no device"),
            ("robot: {}", "lab.yaml:1: robot: no such key; did you mean 'robots'?"),
            (robot + "    adress: b", "lab.yaml:5: robots.fanuc.adress: no such key; did you mean 'address'?"),
            (robot + "    zzz: b", "lab.yaml:5: robots.fanuc.zzz: no such key; there is source"),
            (robot + "    rate: fast", "lab.yaml:5: robots.fanuc.rate: 'fast', where a number from 1 to 250 in Hz"),
            (robot + "    rate: .nan", "rate: 'nan'"), (robot + "    rate: 0", "rate: '0'"),
            (robot + "    wire: sercos", "robots.fanuc.wire: 'sercos', where one of crcl, fanuc_karel"),
            (robot + "    source: proxy", "lab.yaml:5: robots.fanuc.source: it is there twice"),
            (robot + "    gripper: a:2", "robots.fanuc.gripper: it is for Simple Message"),
            (robot + "    listen: here", "robots.fanuc.listen: 'here', where HOST:PORT"),
            (robot + "allow_commands: maybe", "lab.yaml:5: allow_commands: 'maybe', where one of true, false"),
            (robot + "allow_commands: 1", "allow_commands: '1'"),
            ("robots:\n  fanuc: {source: mirror}", "lab.yaml:2: robots.fanuc: it has no 'address'"),
            ("robots:\n  fanuc: {address: 'a:1'}", "it has no 'source'"),
            ('cameras:\n  fanuc: {source: shadow, address: "a:1"}', "lab.yaml:2: cameras.fanuc.source: 'shadow'"),
            ('conveyor: {source: mirror, address: "a:1", forward: true}', "conveyor.forward: 'True'"),
            ("robots: [", "lab.yaml:"), ("a: b: c", "lab.yaml:1: mapping values"),
        ):
            with self.assertRaises(BadArgument, msg=text) as caught:
                self.read(text)
            self.assertIn(told, str(caught.exception), text)
        with self.assertRaisesRegex(BadArgument, "cannot read /none"):
            read_file("/none")


if __name__ == "__main__":
    unittest.main()
