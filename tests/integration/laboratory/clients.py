"""Clients inside the namespace of server/lab. Prints one JSON object; `transfer` also runs the belt."""

import json
import os
import pathlib
import socket
import struct
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
BINARIES = os.environ.get("APRSIM_BIN_DIR", str(ROOT / "build" / "release" / "bin"))
DEADLINE_S = 60 * float(os.environ.get("APRSIM_PATIENCE", "1"))
MOTOMAN, FANUC, CONVEYOR = "192.168.1.33", "192.168.1.34", "192.168.1.50"
CAMERAS = [f"192.168.1.{last}" for last in (104, 105, 107, 108, 110)]
RUN, DIRECTION, SPEED = 0x8000, 0x8001, 0x8002
HALF_SPEED = int(50 * 327.68)
TRANSFER_MS = 5000


def receive(connection, size):
    data = b""
    while len(data) < size:
        more = connection.recv(size - len(data))
        if not more:
            raise ConnectionError("closed")
        data += more
    return data


def state_lengths(address, port):
    """The different lengths of the messages of a state port."""
    lengths = set()
    with socket.create_connection((address, port), 10) as connection:
        while len(lengths) < 2:
            (length,) = struct.unpack(">i", receive(connection, 4))
            receive(connection, length)
            lengths.add(length)
    return sorted(lengths)


def picture(address):
    """The beginning of a camera's stream: code and kind."""
    with socket.create_connection((address, 80), 10) as camera:
        camera.settimeout(DEADLINE_S)
        camera.sendall(b"GET /mjpg/video.mjpg HTTP/1.1\r\nHost: camera\r\n\r\n")
        data = b""
        while b"\xff\xd9" not in data:
            more = camera.recv(1 << 16)
            if not more:
                return f"ends after {data[:100]!r}"
            data += more
    head, _, body = data.partition(b"\r\n\r\n")
    code = head.split(None, 2)[1].decode()
    begins = body.partition(b"\r\n\r\n")[2][:2]
    kind = "JPEG" if begins == b"\xff\xd8" else repr(begins)
    return f"{code} {kind}"


def status():
    done = subprocess.run(
        [os.path.join(BINARIES, "aprsim"), "--ports-file", os.environ["APRSIM_LAB_PORTS"], "status", "--json"],
        capture_output=True,
        text=True,
        timeout=60,
    )
    return json.loads(done.stdout)


def transfer():
    """Writes as NIST's conveyor node does: function 6, unit 0."""
    before = status()
    with socket.create_connection((CONVEYOR, 502), 10) as plc:

        def write(register, value):
            request = struct.pack(">HHHBBHH", 1, 0, 6, 0, 6, register, value)
            plc.sendall(request)
            if receive(plc, 12) != request:
                raise ConnectionError("the answer is no echo")

        write(DIRECTION, 1)
        write(SPEED, HALF_SPEED)
        write(RUN, 1)
        deadline = time.monotonic() + DEADLINE_S
        while int(status()["step"]) < int(before["step"]) + TRANSFER_MS:
            if time.monotonic() > deadline:
                raise TimeoutError("the transfer does not end")
        write(RUN, 0)
        write(SPEED, 0)
    after = status()
    x = {body["name"]: body["body_in_world"]["position_m"].get("x", 0.0) for body in before["bodies"]}
    moved = {
        body["name"]: body["body_in_world"]["position_m"].get("x", 0.0) - x[body["name"]]
        for body in after["bodies"]
        if "tray" in body["type"] or "kit" in body["type"]
    }
    return {
        "travel_m": after["conveyor"].get("travel_m", 0.0),
        "trays_moved": [name for name, way in moved.items() if way > 0.1],
        "trays_moved_against_x": [name for name, way in moved.items() if way < -0.001],
    }


def main():
    if sys.argv[1:] == ["transfer"]:
        print(json.dumps(transfer()))
        return
    refused = []
    for address, port in ((MOTOMAN, 50240), (FANUC, 11000), (MOTOMAN, 50242), (CONVEYOR, 502)):
        try:
            socket.create_connection((address, port), 10).close()
        except OSError as error:
            refused.append(f"{address}:{port}: {error}")
    with socket.create_connection((FANUC, 12123), 10) as gripper:
        gripper.sendall(struct.pack(">i", 3))
        (opened,) = struct.unpack(">i", receive(gripper, 4))
    print(
        json.dumps(
            {
                "fanuc_state": state_lengths(FANUC, 11002),
                "motoman_state": state_lengths(MOTOMAN, 50241),
                "gripper": opened,
                "refused": refused,
                "pictures": {address: picture(address) for address in CAMERAS},
            }
        )
    )


main()
