#!/usr/bin/env python3
"""Makes a recording for test_ros2.py from a session that ros2_sessions.py kept: the client's input, message by message,
the replies, and the changes of the robots' status.

usage: tests/clients/record_ros2.py KEPT_FOLDER > tests/clients/recordings/ros2/NAME.txt"""

import json
import pathlib
import struct
import sys

from ros2_messages import (
    STATUS_LENGTH,
    is_busy,
    joints_of,
    packed,
    split_messages,
    status_of,
)

QUIET_S = 0.5  # without a state


class Recorder:
    def __init__(self, chunks):
        self.lines = []
        self.at = 0.0  # of the last line
        self.rest = {}  # bytes of the daemon by connection, not yet a whole message
        self.sent = {}  # latest request of each motion connection
        self.resent = set()  # connections whose latest request was answered BUSY
        self.status, self.heard, self.quiet = {}, {}, set()
        self.busy, self.joints = {}, {}
        self.ended = set()  # (connection, side)
        for chunk in chunks:
            self.find_quiet(chunk)
            data = None if chunk["data"] is None else chunk["data"].encode("latin-1")
            if chunk["target"] == "cell":
                self.put("cell", chunk, data.decode())
            elif data is None:
                self.put("open", chunk, chunk["target"])
            elif not data:
                self.end(chunk)
            elif chunk["from"] == "client":
                self.request(chunk, data)
            elif chunk["target"].startswith("state."):
                self.states(chunk, data)
            else:
                self.replies(chunk, data)

    def put(self, verb, chunk, text=""):
        gap_ms = round(1e3 * (chunk["at"] - self.at))
        self.at = chunk["at"]
        self.lines.append(f"{verb} {chunk['connection']} {gap_ms} {text}".rstrip())

    def end(self, chunk):
        number = chunk["connection"]
        other = ("server" if chunk["from"] == "client" else "client", number)
        if other not in self.ended:
            self.put("close" if chunk["from"] == "client" else "gone", chunk)
        self.ended.add((chunk["from"], number))
        self.heard.pop(number, None)

    def request(self, chunk, data):
        number = chunk["connection"]
        if number in self.resent and data == self.sent[number]:
            return
        self.resent.discard(number)
        self.sent[number] = data
        self.put("send", chunk, packed(data))

    def replies(self, chunk, data):
        number, robot = chunk["connection"], chunk["target"].split(".")[1]
        framed = chunk["target"] != "gripper.fanuc"
        messages, self.rest[number] = split_messages(self.rest.get(number, b"") + data, framed)
        for message in messages:
            if is_busy(message):
                self.busy[robot] = self.busy.get(robot, 0) + 1
                self.resent.add(number)
            else:
                self.put("reply", chunk, packed(message))

    def states(self, chunk, data):
        number, robot = chunk["connection"], chunk["target"].split(".")[1]
        self.heard[number] = chunk
        self.quiet.discard(number)
        messages, self.rest[number] = split_messages(self.rest.get(number, b"") + data, True)
        for message in messages:
            if struct.unpack(">i", message[:4])[0] == STATUS_LENGTH:
                status = status_of(message)
                if status != self.status.get(number):
                    self.status[number] = status
                    self.put("status", chunk, " ".join(map(str, status)))
            else:
                self.joints[robot] = joints_of(message)

    def find_quiet(self, chunk):
        for number, last in self.heard.items():
            since = chunk["at"] - last["at"]
            if since > QUIET_S and number not in self.quiet:
                self.quiet.add(number)
                self.put("quiet", {"connection": number, "at": max(self.at, last["at"] + QUIET_S)})


def main():
    folder = pathlib.Path(sys.argv[1])
    with open(folder / "exchange.jsonl", encoding="utf-8") as file:
        chunks = [json.loads(line) for line in file]
    end = json.loads((folder / "end.json").read_text(encoding="utf-8"))
    print("\n".join(["# " + end["session"], "option " + " ".join(end["options"])]))
    recorder = Recorder(chunks)
    print("\n".join(recorder.lines))
    for robot, count in sorted(recorder.busy.items()):
        print(f"busy {robot} {count}")
    for robot, joints in sorted(recorder.joints.items()):
        print(f"joints {robot} " + " ".join(f"{joint:.4f}" for joint in joints))


if __name__ == "__main__":
    main()
