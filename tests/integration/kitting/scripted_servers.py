"""Servers on real sockets that answer as a test wants."""

import re
import socket
import struct
import threading


class Server:
    """Serves every connection by `serve(connection)` in a thread of its own."""

    def __init__(self):
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self._connections = []
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            self._connections.append(connection)
            threading.Thread(target=self._run, args=(connection,), daemon=True).start()

    def _run(self, connection):
        try:
            self.serve(connection)
        except OSError:
            pass
        finally:
            connection.close()

    def close(self):
        # A listener that somebody waits at goes on listening when it is only closed.
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        for connection in self._connections:
            connection.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class CrclServer(Server):
    """A robot. `script`: of a kind of command, what to answer each time it comes: done, working,
    error TEXT, close, other (somebody else's command); the last for ever."""

    def __init__(self, script=None):
        self.script = {kind: list(answers) for kind, answers in (script or {}).items()}
        self.received = []
        self.asked_working = 0  # statuses that said so
        self.holding = "false"
        self.grips = False  # whether it holds something when the gripper has closed
        self.command, self.state, self.text = 1, "CRCL_Done", ""
        super().__init__()

    def serve(self, connection):
        data = b""
        while True:
            more = connection.recv(1 << 16)
            if not more:
                return
            data += more
            while b"</CRCLCommandInstance>" in data:
                document, data = data.split(b"</CRCLCommandInstance>", 1)
                kind = re.search(rb'CRCLCommand xmlns:xsi="[^"]*" xsi:type="(\w+)Type"', document)[
                    1
                ].decode()
                number = int(re.search(rb"<CommandID>(-?\d+)<", document)[1])
                if kind == "GetStatus":
                    if self.state == "close":
                        return
                    self.asked_working += self.state == "CRCL_Working"
                    connection.sendall(self.status().encode())
                else:
                    self.received.append(kind)
                    if kind == "SetEndEffector" and self.grips:
                        self.holding = (
                            "false"
                            if float(re.search(rb"<Setting>([\d.]+)<", document)[1]) > 0.5
                            else "true"
                        )
                    self.take(kind, number)

    def take(self, kind, number):
        answers = self.script.get(kind, ["done"])
        answer = answers.pop(0) if len(answers) > 1 else answers[0]
        self.command, self.text = number, answer.removeprefix("error ")
        if answer == "other":
            self.command = number + 100
        self.state = {"working": "CRCL_Working", "close": "close"}.get(
            answer, "CRCL_Error" if answer.startswith("error") else "CRCL_Done"
        )

    def status(self):
        return (
            f"<CRCLStatus><CommandStatus><CommandID>{self.command}</CommandID><StatusID>1</StatusID>"
            f"<CommandState>{self.state}</CommandState><StateDescription>{self.text}</StateDescription>"
            "</CommandStatus><PoseStatus><Pose><Point><X>300</X><Y>0</Y><Z>400</Z></Point>"
            "<XAxis><I>-1</I><J>0</J><K>0</K></XAxis></Pose></PoseStatus>"
            f"<GripperStatus><GripperName>g</GripperName><HoldingObject>{self.holding}</HoldingObject>"
            "<Separation>20</Separation></GripperStatus></CRCLStatus>"
        )


class VisionServer(Server):
    """Sends these lines, one after the other and again from the first, every few milliseconds."""

    def __init__(self, lines):
        self.lines = list(lines)
        super().__init__()

    def serve(self, connection):
        pause = threading.Event()
        while True:
            for line in list(self.lines):
                connection.sendall(line.encode() + b"\n")
                pause.wait(0.005)


class ModbusServer(Server):
    """A belt. `answer(function, address, value)`: bytes of the PDU to send, or a list of such with
    transaction offsets; None for what a belt does."""

    def __init__(self, answer=lambda *_: None, counts_a_read=500):
        self.answer, self.counts_a_read = answer, counts_a_read
        self.written = []
        self.position = 0
        self.runs = self.backward = False
        super().__init__()

    def serve(self, connection):
        while True:
            header = self._take(connection, 7)
            transaction, _, length, unit = struct.unpack(">HHHB", header)
            function, address, value = struct.unpack(">BHH", self._take(connection, length - 1))
            answers = self.answer(function, address, value)
            if answers is None:
                answers = [(0, self.act(function, address, value))]
            for offset, pdu in answers:
                connection.sendall(
                    struct.pack(">HHHB", (transaction + offset) & 0xFFFF, 0, len(pdu) + 1, unit)
                    + pdu
                )

    def act(self, function, address, value):
        if function == 6:
            self.written.append((address, value))
            if address == 0x8000:
                self.runs = bool(value)
            if address == 0x8001:
                self.backward = not value
            return struct.pack(">BHH", 6, address, value)
        if self.runs:
            self.position += -self.counts_a_read if self.backward else self.counts_a_read
        return struct.pack(">BBi", 4, 4, self.position)

    @staticmethod
    def _take(connection, size):
        data = b""
        while len(data) < size:
            more = connection.recv(size - len(data))
            if not more:
                raise OSError("closed")
            data += more
        return data
