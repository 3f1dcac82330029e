"""A daemon to attack, and the clients that look on meanwhile: standard library only."""

import json
import multiprocessing
import os
import re
import resource
import signal
import socket
import ssl
import struct
import subprocess
import sys
import tempfile
import threading
import time

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "integration", "access"))
from authority import Authority  # noqa: E402

PRELUDE = (
    '<?xml version="1.0" encoding="UTF-8"?><CRCLCommandInstance '
    'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><CRCLCommand xsi:type="'
)


def document(kind, number, fields=""):
    """One CRCL command as it goes over the wire."""
    return (
        f'{PRELUDE}{kind}Type"><CommandID>{number}</CommandID>{fields}'
        "</CRCLCommand></CRCLCommandInstance>"
    ).encode()


def pose(element, x_mm, y_mm, z_mm):
    """A pose with the tool pointing down."""
    return (
        f"<{element}><Point><X>{x_mm}</X><Y>{y_mm}</Y><Z>{z_mm}</Z></Point>"
        "<XAxis><I>1</I><J>0</J><K>0</K></XAxis><ZAxis><I>0</I><J>0</J><K>-1</K></ZAxis>"
        f"</{element}>"
    )


class Crcl:
    """A CRCL client that asks for a status and waits for it."""

    def __init__(self, port, timeout=10):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.number = 0
        self.buffer = b""

    def send(self, kind, fields=""):
        self.number += 1
        self.socket.sendall(document(kind, self.number, fields))
        return self.number

    def status(self):
        self.socket.sendall(document("GetStatus", self.number))
        while b"</CRCLStatus>" not in self.buffer:
            data = self.socket.recv(1 << 16)
            if not data:
                raise ConnectionError("closed while a status was expected")
            self.buffer += data
        text, self.buffer = self.buffer.split(b"</CRCLStatus>", 1)
        return text.decode()

    def close(self):
        self.socket.close()


class Modbus:
    """A Modbus client that writes coils."""

    STOP = 0x8002

    def __init__(self, port, timeout=10):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout)
        self.transaction = 0

    def write_coil(self, address, value):
        """The exception code of the answer, 0 for none."""
        self.transaction = (self.transaction + 1) & 0xFFFF
        self.socket.sendall(
            struct.pack(
                ">HHHBBHH", self.transaction, 0, 6, 1, 5, address, 0xFF00 if value else 0
            )
        )
        reply = b""
        while len(reply) < 9:
            data = self.socket.recv(64)
            if not data:
                raise ConnectionError("closed while an answer was expected")
            reply += data
        return reply[8] if reply[7] & 0x80 else 0

    def close(self):
        self.socket.close()


class Http2:
    """HTTP/2 frames by hand, over a socket to the gRPC port."""

    HEADERS, RST_STREAM, SETTINGS, PING, CONTINUATION = 1, 3, 4, 6, 9
    END_STREAM, END_HEADERS = 1, 4

    def __init__(self, port, timeout=5):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.sendall(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + self.frame(self.SETTINGS, 0, 0))
        self.stream = -1

    @staticmethod
    def frame(kind, flags, stream, payload=b""):
        return struct.pack(">I", len(payload))[1:] + struct.pack(">BBI", kind, flags, stream) + payload

    @staticmethod
    def headers_of(method, metadata=()):
        """A header block, nothing in it indexed; metadata in names and values below 127 bytes."""
        literal = lambda text: bytes([len(text)]) + text  # noqa: E731
        return (
            b"\x83\x86\x04" + literal(method) + b"\x01" + literal(b"cell")
            + b"\0" + literal(b"te") + literal(b"trailers")
            + b"\0" + literal(b"content-type") + literal(b"application/grpc")
            + b"".join(b"\0" + literal(name) + literal(value) for name, value in metadata)
        )

    def open_call(self, method=b"/aprsim.v1.TelemetryService/GetCell", metadata=()):
        """The frame that opens a call."""
        self.stream += 2
        return self.frame(
            self.HEADERS, self.END_HEADERS, self.stream, self.headers_of(method, metadata)
        )

    def call(self, method, message=b""):
        """The frames of a whole call of one message."""
        head = self.open_call(method)
        body = b"\0" + struct.pack(">I", len(message)) + message
        return head + self.frame(0, self.END_STREAM, self.stream, body)

    def reset(self):
        """The frame that gives the last call up."""
        return self.frame(self.RST_STREAM, 0, self.stream, struct.pack(">I", 8))

    def read_some(self):
        """Reads and forgets what is there; False at the end."""
        self.socket.setblocking(False)
        try:
            while True:
                if not self.socket.recv(1 << 16):
                    return False
        except (BlockingIOError, InterruptedError):
            return True
        finally:
            self.socket.setblocking(True)

    def close(self):
        self.socket.close()


class SecureModbus:
    """Certificates for Modbus Security: of the server, of clients, and of clients that are not served."""

    ROLE = "1.3.6.1.4.1.50316.802.1"

    def __init__(self, folder):
        authority, other = Authority(folder), Authority(folder, "other")
        self.authority = authority.certificate
        self.server = authority.certify("server", "IP:127.0.0.1")

        def role(name, text, by=authority, form="UTF8String"):
            return by.certify(name, extensions=(f"{self.ROLE}=ASN1:{form}:{text}",))

        self.viewer, self.operator = role("viewer", "Viewer"), role("operator", "Operator")
        self.unserved = [
            None,
            role("stranger", "Operator", other),
            role("long", "x" * 400),
            role("printable", "Operator", form="PRINTABLESTRING"),
            role("control", "Opera\x01tor"),
        ]
        self.arguments = [
            word
            for key, value in (
                ("certificate", self.server.certificate),
                ("key", self.server.key),
                ("client_ca", self.authority),
                ("roles", "{Viewer: view, Operator: operate}"),
            )
            for word in ("--set", f"modbus.tls.{key}={value}")
        ]

    def context(self, certified):
        """The context of a client with this certificate; None: without one."""
        context = ssl.create_default_context(cafile=self.authority)
        if certified:
            context.load_cert_chain(certified.certificate, certified.key)
        return context

    def connect(self, port, context, timeout=5):
        plain = socket.create_connection(("127.0.0.1", port), timeout)
        try:
            return context.wrap_socket(plain, server_hostname="127.0.0.1")
        except OSError:
            plain.close()
            raise

    def greeting(self):
        """The first bytes of a client."""
        out = ssl.MemoryBIO()
        tls = self.context(self.viewer).wrap_bio(ssl.MemoryBIO(), out, server_hostname="127.0.0.1")
        try:
            tls.do_handshake()
        except ssl.SSLWantReadError:
            pass
        return out.read()


class Daemon:
    """aprsimd on ports of its own, with what it uses measured, and little memory for its past, so
    that what else grows is seen. `log_pipe`: its log goes into a pipe that nobody reads; `files`:
    its hard limit of open files; `before`: words before its program; `enter`: called in its process
    before the program starts; `secure`: with Modbus Security, see SecureModbus."""

    LITTLE_PAST = ("--set", "history.max_mb=16", "--set", "journal.memory_mb=16")

    def __init__(self, binaries, *arguments, log_pipe=False, files=None, before=(), enter=None,
                 secure=False):
        self.binaries = binaries

        def begin():
            if files:
                resource.setrlimit(resource.RLIMIT_NOFILE, (files, files))
            if enter:
                enter()

        self.folder = tempfile.TemporaryDirectory(prefix="aprsim-attack-")
        self.security = SecureModbus(self.folder.name) if secure else None
        arguments = (*arguments, *(self.security.arguments if secure else ()))
        ports = os.path.join(self.folder.name, "ports.json")
        self.log = open(os.path.join(self.folder.name, "log"), "wb")
        self.pipe = os.pipe() if log_pipe else ()
        self.process = subprocess.Popen(
            [*before, os.path.join(binaries, "aprsimd"), "--any-port", "--ports-file", ports]
            + [*self.LITTLE_PAST, *arguments],
            stdout=self.log,
            stderr=self.pipe[1] if log_pipe else subprocess.STDOUT,
            preexec_fn=begin if files or enter else None,
        )
        deadline = time.monotonic() + 60
        while not os.path.exists(ports):
            if self.process.poll() is not None or time.monotonic() > deadline:
                raise RuntimeError("aprsimd does not start: " + self.log_text())
            time.sleep(0.02)
        with open(ports, encoding="utf-8") as file:
            self.ports = json.load(file)
        self.ports.pop("pid")
        self.ports_file = ports

    def log_text(self):
        with open(os.path.join(self.folder.name, "log"), encoding="utf-8", errors="replace") as file:
            return file.read()

    def rss_mb(self, field="VmRSS"):
        with open(f"/proc/{self.process.pid}/status", encoding="ascii") as file:
            return int(re.search(field + r":\s+(\d+)", file.read()).group(1)) / 1024

    def status(self):
        """Returns exit code and text of `aprsim status`."""
        done = subprocess.run(
            [os.path.join(self.binaries, "aprsim"), "--ports-file", self.ports_file, "status"],
            capture_output=True,
            text=True,
            timeout=30,
        )
        return done.returncode, done.stdout + done.stderr

    def missed_steps(self):
        found = re.search(r"(\d+) steps missed", self.status()[1])
        return int(found.group(1)) if found else None

    def simulated_ms(self, robot="motoman"):
        """The step that the simulation has reached, by the CRCL parameter simulated_time."""
        client = Crcl(self.ports["crcl." + robot])
        client.send("InitCanon")
        client.send(
            "EnableRobotParameterStatus",
            "<RobotParameterName>simulated_time</RobotParameterName>",
        )
        text = client.status()
        client.close()
        found = re.search(
            r"<ParameterName>simulated_time</ParameterName><ParameterValue>([\d.]+)<", text
        )
        return float(found.group(1)) * 1000

    def stop(self):
        """SIGTERM; the exit code and how long it took [s]."""
        began = time.monotonic()
        self.process.send_signal(signal.SIGTERM)
        try:
            code = self.process.wait(30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = "hangs"
        self.log.close()
        return code, time.monotonic() - began

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.log.close()
        for end in self.pipe:
            os.close(end)
        self.pipe = ()
        self.folder.cleanup()


class Observer:
    """Other clients, which go on as always while an attack runs, in a process of their own: a
    status of the other robot every 10 ms, an emergency stop every 400 ms, and the memory's peak."""

    def __init__(self, daemon):
        self.daemon = daemon
        self.status_ms, self.stop_ms, self.faults = [], [], []
        self.peak_mb = daemon.rss_mb()
        self._ended = multiprocessing.Event()
        self._served = multiprocessing.Semaphore(0)
        self._results = multiprocessing.Queue()
        self._process = multiprocessing.Process(target=self._run, daemon=True)

    def __enter__(self):
        self._process.start()
        # Clients that come during an attack are the attack's business.
        for _ in range(2):
            self._served.acquire(timeout=30)
        return self

    def __exit__(self, *_):
        self._ended.set()
        self.status_ms, self.stop_ms, self.faults, self.peak_mb = self._results.get(timeout=60)
        self._process.join()

    def _run(self):
        threads = [
            threading.Thread(target=run, daemon=True)
            for run in (self._statuses, self._stops, self._memory)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self._results.put((self.status_ms, self.stop_ms, self.faults, self.peak_mb))

    def _statuses(self):
        try:
            client = Crcl(self.daemon.ports["crcl.motoman"])
            client.status()
            self._served.release()
            while not self._ended.wait(0.01):
                began = time.monotonic()
                client.status()
                self.status_ms.append((time.monotonic() - began) * 1e3)
        except OSError as error:
            self.faults.append(f"status: {error}")

    def _stops(self):
        try:
            client = Modbus(self.daemon.ports["modbus"])
            client.write_coil(Modbus.STOP, False)
            self._served.release()
            stopped = True
            while not self._ended.wait(0.2):
                began = time.monotonic()
                code = client.write_coil(Modbus.STOP, stopped)
                took = (time.monotonic() - began) * 1e3
                if code:
                    what = "emergency stop" if stopped else "release of the emergency stop"
                    self.faults.append(f"{what}: exception {code}")
                if stopped:
                    self.stop_ms.append(took)
                stopped = not stopped
        except OSError as error:
            self.faults.append(f"emergency stop: {error}")

    def _memory(self):
        while not self._ended.wait(0.05):
            try:
                self.peak_mb = max(self.peak_mb, self.daemon.rss_mb())
            except (OSError, AttributeError):
                return


def percentile(values, share):
    """The value at a share of the sorted list; None when it is empty."""
    if not values:
        return None
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]
