#!/usr/bin/env python3
"""A CRCL server that is wrong on purpose: what a check of servers has to find.

usage: wrong_crcl_server.py    prints its port, and serves until its input ends

It answers every command and not only GetStatus, tells the id of a GetStatus as the command's, knows
no units, has no errors but one: it refuses commands after EndCanon. It never begins a new StatusID,
and its statuses are not valid by the schema.
"""

import re
import socketserver
import sys
import threading


class Client(socketserver.BaseRequestHandler):
    def handle(self) -> None:
        received = b""
        ended = False
        while data := self.request.recv(65536):
            *documents, received = (received + data).split(b"</CRCLCommandInstance>")
            for document in documents:
                ids = re.findall(rb"<CommandID>(-?\d+)</CommandID>", document)
                last = ids[-1].decode() if ids else "0"
                state = "CRCL_Error" if ended and b"InitCanon" not in document else "CRCL_Done"
                ended = b"EndCanon" in document or (ended and b"InitCanon" not in document)
                try:
                    self.request.sendall(
                        f'<?xml version="1.0"?><CRCLStatus><CommandStatus><CommandID>{last}'
                        "</CommandID><StatusID>1</StatusID><CommandState>{state}</CommandState>"
                        "</CommandStatus><JointStatuses></JointStatuses></CRCLStatus>\n".encode()
                    )
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
