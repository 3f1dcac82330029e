"""Simple Message as far as recordings need it, and their form of bytes: words of four bytes in hexadecimal, zN for N
words of zeros."""

import itertools
import struct

JOINTS_LENGTH, STATUS_LENGTH, FEEDBACK_LENGTH = 56, 40, 144
MOTION_REPLY, BUSY = 2002, 1


def split_messages(data, framed):
    """The whole messages at the beginning, and the rest."""
    messages = []
    while len(data) >= 4:
        size = 4 + (struct.unpack(">i", data[:4])[0] if framed else 0)
        if len(data) < size:
            break
        messages.append(data[:size])
        data = data[size:]
    return messages, data


def is_busy(message):
    return (
        len(message) == 76
        and struct.unpack(">i", message[4:8])[0] == MOTION_REPLY
        and struct.unpack(">i", message[28:32])[0] == BUSY
    )


def status_of(message):
    """All fields but in_motion, which depends on the pace."""
    drives, e_stopped, code, error, _, mode, possible = struct.unpack(">7i", message[16:44])
    return drives, e_stopped, code, error, mode, possible


def joints_of(message):
    """The joints of a position or feedback message [rad]."""
    begin = 20 if len(message) == 4 + JOINTS_LENGTH else 28
    return struct.unpack(">10f", message[begin : begin + 40])


def packed(data):
    words = [data[i : i + 4].hex() for i in range(0, len(data), 4)]
    parts = []
    for word, run in itertools.groupby(words):
        count = len(list(run))
        parts += [f"z{count}"] if word == "00000000" else [word] * count
    return ",".join(parts)


def unpacked(text):
    return b"".join(
        bytes(4 * int(part[1:])) if part.startswith("z") else bytes.fromhex(part) for part in text.split(",")
    )
