"""The stream that is read, the lines that are served, and the files and arguments of the command."""

import contextlib
import io
import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from stack import PATIENCE, ROOT

import numpy as np

from clients.vision.errors import VisionError
from clients.vision.mjpeg import MjpegReader, StreamError, read_head, read_picture
from clients.vision.prior import read_prior
from clients.vision.publisher import LinePublisher, SeenObject, vision_line

sys.path.insert(0, str(ROOT / "clients" / "kitting"))
import vision as kitting_vision  # noqa: E402

HEAD = b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=myboundary\r\n\r\n"


def part(data):
    length = str(len(data)).encode()
    return (
        b"--myboundary\r\nContent-Type: image/jpeg\r\nContent-Length: " + length + b"\r\n\r\n" + data + b"\r\n"
    )


def eventually(condition, what):
    deadline = time.monotonic() + 30 * PATIENCE
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            raise AssertionError(f"not within {30 * PATIENCE:g} s: {what}")
        time.sleep(0.01)


class ParseTest(unittest.TestCase):
    def test_reads_pictures_one_after_the_other(self):
        stream = io.BytesIO(HEAD + part(b"one") + part(b"--myboundary\r\n") + part(b"three"))
        delimiter = read_head(stream)
        self.assertEqual(delimiter, b"--myboundary")
        pictures = [read_picture(stream, delimiter) for _ in range(3)]
        self.assertEqual(pictures, [b"one", b"--myboundary\r\n", b"three"])
        with self.assertRaisesRegex(StreamError, "ended"):
            read_picture(stream, delimiter)

    def test_a_wrong_head_is_refused(self):
        for head, text in (
            (b"", "ended"),
            (b"SSH-2.0\r\n\r\n", "200 is expected"),
            (b"HTTP/1.1 404 Not Found\r\n\r\n", "404"),
            (b"HTTP/1.1 200 OK\r\nContent-Type: text/html\r\n\r\n", "text/html"),
            (HEAD.replace(b"; boundary=myboundary", b""), "content type"),
            (b"HTTP/1.1 200 OK\r\n" + b"A: b\r\n" * 65 + b"\r\n", "64 headers"),
            (b"HTTP/1.1 200 " + b"x" * 5000, "too long"),
        ):
            with self.subTest(head=head[:40]), self.assertRaisesRegex(StreamError, text):
                read_head(io.BytesIO(head))

    def test_a_wrong_part_is_refused(self):
        good = part(b"data")
        for data, text in (
            (good.replace(b"--my", b"--your"), "yourboundary"),
            (good.replace(b": 4", b": -4"), "Content-Length '-4'"),
            (good.replace(b": 4", b": 0"), "Content-Length '0'"),
            (good.replace(b": 4", b": 99999999"), "Content-Length"),
            (good.replace(b"Content-Length", b"Length"), "Content-Length ''"),
            (good[:-4], "within a picture"),
        ):
            with self.subTest(data=data[:60]), self.assertRaisesRegex(StreamError, text):
                read_picture(io.BytesIO(data), b"--myboundary")


class ScriptedCamera:
    """A camera that sends what the test says to each connection."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.listener.settimeout(30 * PATIENCE)
        self.url = f"http://127.0.0.1:{self.listener.getsockname()[1]}/mjpg/video.mjpg"

    def accept(self):
        connection, _ = self.listener.accept()
        request = b""
        while not request.endswith(b"\r\n\r\n"):
            request += connection.recv(4096)
        return connection, request


class ReaderTest(unittest.TestCase):
    def setUp(self):
        self.camera = ScriptedCamera()
        self.addCleanup(self.camera.listener.close)
        self.reader = MjpegReader(self.camera.url)
        self.addCleanup(self.reader.close)

    def test_the_latest_picture_wins(self):
        connection, request = self.camera.accept()
        self.addCleanup(connection.close)
        self.assertTrue(request.startswith(b"GET /mjpg/video.mjpg HTTP/1.0\r\n"), request)
        self.assertIsNone(self.reader.latest(0, 0.01))
        connection.sendall(HEAD + b"".join(part(b"picture %d" % i) for i in range(1, 101)))
        eventually(lambda: self.reader.latest(99, 0.1), "100 pictures")
        frame = self.reader.latest(0, 0)
        self.assertEqual((frame.number, frame.jpeg), (100, b"picture 100"))
        self.assertIsNone(self.reader.latest(100, 0.01))

    def test_pieces_make_a_picture(self):
        connection, _ = self.camera.accept()
        self.addCleanup(connection.close)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for byte in HEAD + part(b"whole"):
            connection.sendall(bytes([byte]))
        self.assertEqual(self.reader.latest(0, 30 * PATIENCE).jpeg, b"whole")

    def test_connects_again(self):
        connection, _ = self.camera.accept()
        connection.sendall(HEAD + part(b"first") + b"rubbish\r\n")
        self.assertEqual(self.reader.latest(0, 30 * PATIENCE).jpeg, b"first")
        again, _ = self.camera.accept()
        self.addCleanup(again.close)
        connection.close()
        self.assertIn("rubbish", self.reader.trouble)
        again.sendall(HEAD + part(b"second"))
        frame = self.reader.latest(1, 30 * PATIENCE)
        self.assertEqual((frame.number, frame.jpeg), (2, b"second"))

    def test_closes_while_the_stream_is_silent(self):
        connection, _ = self.camera.accept()
        self.addCleanup(connection.close)
        connection.sendall(HEAD)
        self.reader.close()
        self.assertFalse(self.reader._thread.is_alive())

    def test_wrong_addresses_are_refused(self):
        for url in ("rtsp://127.0.0.1/", "http:///video", "http://127.0.0.1:banana/", "127.0.0.1"):
            with self.subTest(url=url), self.assertRaises(VisionError):
                MjpegReader(url)


class LineTest(unittest.TestCase):
    SEEN = (
        SeenObject("sku_kit_m2l1_vessel", "KT", -113.82, 548.295, 3.0541, 1.0),
        SeenObject("sku_part_large_gear", "P", 34.793, 327.335, 0.0, 0.99),
    )
    LINE = (
        b"sku_kit_m2l1_vessel,3.0541,-113.820,548.295,1.00,KT,"
        b"sku_part_large_gear,0.0000,34.793,327.335,0.99,P,\n"
    )

    def test_a_line_is_as_the_cells_own(self):
        self.assertEqual(vision_line(self.SEEN), self.LINE)
        self.assertEqual(vision_line([]), b"\n")
        tray, gear = kitting_vision.parse_line(self.LINE.decode())
        self.assertEqual((tray.name, tray.kind, tray.pose.x, tray.pose.y), ("sku_kit_m2l1_vessel", "KT", -113.82, 548.295))
        self.assertEqual((gear.name, gear.kind, gear.score), ("sku_part_large_gear", "P", 0.99))

    def test_every_client_gets_whole_lines(self):
        publisher = LinePublisher("127.0.0.1", 0)
        self.addCleanup(publisher.close)
        clients = [socket.create_connection(("127.0.0.1", publisher.port)) for _ in range(3)]
        for client in clients:
            self.addCleanup(client.close)
            client.settimeout(30 * PATIENCE)
        for _ in range(3):
            publisher.publish(self.LINE)
        for client in clients:
            with client.makefile("rb") as stream:
                self.assertEqual([stream.readline() for _ in range(3)], [self.LINE] * 3)

    def test_a_slow_client_misses_lines_and_gets_whole_ones(self):
        publisher = LinePublisher("127.0.0.1", 0)
        self.addCleanup(publisher.close)
        slow = socket.socket()
        self.addCleanup(slow.close)
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        slow.settimeout(30 * PATIENCE)
        slow.connect(("127.0.0.1", publisher.port))
        lines = [str(i).encode() * 20000 + b"\n" for i in range(1, 400)]
        for line in lines:
            publisher.publish(line)
        publisher.publish(b"x")  # flushes as far as the client lets it
        done = threading.Event()
        received = []

        def read():
            with contextlib.suppress(OSError), slow.makefile("rb") as stream:
                for line in stream:
                    received.append(line)
                    if line == b"last\n":
                        done.set()
                        return

        threading.Thread(target=read, daemon=True).start()

        def is_done():
            publisher.publish(b"last\n")
            return done.is_set()

        eventually(is_done, "the last line")
        whole = set(lines) | {b"xlast\n", b"last\n"}
        self.assertTrue(all(line in whole for line in received))
        self.assertLess(len(received), len(lines), "some were missed")

    def test_a_client_too_many_is_turned_away(self):
        publisher = LinePublisher("127.0.0.1", 0)
        self.addCleanup(publisher.close)
        clients = []
        for _ in range(17):
            clients.append(socket.create_connection(("127.0.0.1", publisher.port)))
            self.addCleanup(clients[-1].close)
            publisher.publish(b"line\n")
        clients[-1].settimeout(30 * PATIENCE)
        self.assertEqual(clients[-1].recv(100), b"")

    def test_a_used_port_is_refused(self):
        publisher = LinePublisher("127.0.0.1", 0)
        self.addCleanup(publisher.close)
        with self.assertRaisesRegex(VisionError, f"port {publisher.port}"):
            LinePublisher("127.0.0.1", publisher.port)


class CommandTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def run_command(self, *arguments):
        return subprocess.run(
            [sys.executable, "-m", "clients.vision", *arguments],
            cwd=ROOT,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
            timeout=120 * PATIENCE,
        )

    def test_wrong_arguments_and_files(self):
        wrong = self.folder / "wrong.toml"
        wrong.write_text("looks = 1\n")
        for arguments, text in (
            (["--cell", "nowhere"], "nowhere.toml"),
            (["--cell", str(wrong)], "the key 'cell' is missing"),
            (["--camera", "roof=http://127.0.0.1/"], "--camera: 'roof=http://127.0.0.1/'"),
            (["--camera", "fanuc_table=rtsp://127.0.0.1/", "--once"], "rtsp://127.0.0.1/"),
            (["--maps", "cell"], "--maps cell: "),
            (["--ports-file", str(self.folder / "none")], "--ports-file"),
        ):
            with self.subTest(arguments=arguments):
                done = self.run_command(*arguments)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn(text, done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)

    def test_serves_lines_of_a_stream(self):
        """Pictures of a scripted camera come out as lines on the port in the written ports file."""
        from drawing import Drawing, DrawnTray

        from clients.vision.silhouette import Pose

        prior = read_prior("aprs_2025")
        kind = next(k for k in prior.trays if k.name == "sku_kit_s2l2_vessel")
        pictures = {}
        for name, camera in prior.cameras.items():
            x, y = camera.map.points(np.array([camera.map.size_px]) / 2.0, 839)[0, :2]
            drawing = Drawing(camera.map, 839)
            drawing.tray(DrawnTray(kind, 1, Pose(float(x), float(y), 0.0), ("lg_1",)))
            pictures[name] = drawing.finished(1)
        cameras = {name: ScriptedCamera() for name in pictures}
        for camera in cameras.values():
            self.addCleanup(camera.listener.close)
        given = self.folder / "ports.json"
        given.write_text(json.dumps({"crcl.fanuc": 1, "vision.fanuc": 2}))
        written = self.folder / "written.json"
        arguments = [f"--camera={name}={camera.url}" for name, camera in cameras.items()]
        arguments += ["--any-port", f"--ports-file={given}", f"--write-ports={written}"]
        program = subprocess.Popen([sys.executable, "-m", "clients.vision", *arguments], cwd=ROOT)
        self.addCleanup(program.wait, 30 * PATIENCE)
        self.addCleanup(program.terminate)
        streams = {}
        for name, camera in cameras.items():
            streams[name], _ = camera.accept()
            self.addCleanup(streams[name].close)
            streams[name].sendall(HEAD + part(b"rubbish") + part(pictures[name]))
        eventually(written.exists, "the ports file")
        ports = json.loads(eventually(lambda: written.read_text(), "its text"))
        self.assertEqual(ports["crcl.fanuc"], 1)
        for name, prior_camera in prior.cameras.items():
            with socket.create_connection(("127.0.0.1", ports[f"vision.{prior_camera.robot}"])) as client:
                client.settimeout(0.5)
                line = b""

                def has_line():
                    nonlocal line
                    streams[name].sendall(part(pictures[name]))
                    with contextlib.suppress(TimeoutError):
                        line += client.recv(4096)
                    return line.count(b"\n")

                eventually(has_line, f"a line of {name}")
            names = [seen.name for seen in kitting_vision.parse_line(line.split(b"\n")[0].decode())]
            self.assertEqual(names, ["sku_kit_s2l2_vessel", "sku_part_large_gear"])


if __name__ == "__main__":
    unittest.main()
