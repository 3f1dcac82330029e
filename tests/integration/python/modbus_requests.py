"""Modbus requests of tests."""

import struct


def ask(connection, unit):
    """A Modbus request, and its reply."""
    connection.sendall(struct.pack(">HHHB", 7, 0, len(unit) + 1, 1) + unit)
    head = b""
    while len(head) < 7:
        head += connection.recv(7 - len(head))
    left = struct.unpack(">H", head[4:6])[0] - 1
    while left > 0:
        left -= len(connection.recv(left))
