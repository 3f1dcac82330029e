#!/usr/bin/env python3
"""A Modbus/TCP server that is wrong on purpose: what a check of servers has to find.

usage: wrong_modbus_server.py    prints its port, and serves until its input ends

It answers every packet as one request, always with unit 1, with ones in place of values, has every
address, knows no quantity that is too large, and executes what has a foreign protocol id.
"""

import socketserver
import struct
import sys
import threading


class Client(socketserver.BaseRequestHandler):
    def handle(self) -> None:
        while data := self.request.recv(4096):
            if len(data) < 8:
                continue
            transaction, function = data[:2], data[7]
            quantity = struct.unpack(">H", data[10:12])[0] if len(data) >= 12 else 1
            if function in (1, 2):
                size = min((quantity + 7) // 8, 250)
                body = bytes([function, size]) + b"\xff" * size
            elif function in (3, 4, 23):
                size = min(2 * quantity, 250)
                body = bytes([function, size]) + b"\xff" * size
            else:
                body = data[7:12]
            try:
                self.request.sendall(transaction + struct.pack(">HHB", 0, len(body) + 1, 1) + body)
            except OSError:
                return


class Server(socketserver.ThreadingTCPServer):
    allow_reuse_address = True
    daemon_threads = True


if __name__ == "__main__":
    with Server(("127.0.0.1", 0), Client) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        print(server.server_address[1], flush=True)
        sys.stdin.read()
