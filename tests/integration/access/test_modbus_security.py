"""Modbus Security of the daemon: pymodbus and openssl as clients, rights by the role in a certificate,
handshakes that fail, stall and come in floods, faulty files."""

import asyncio
import json
import pathlib
import random
import signal
import socket
import ssl
import struct
import subprocess
import tempfile
import time
import unittest

from aprsim import AprsimError, Daemon
from aprsim.binaries import find_binary
from authority import Authority
from pymodbus.client import AsyncModbusTlsClient
from pymodbus.framer.socket_framer import ModbusSocketFramer
from with_authority import HOST, PATIENCE, WithAuthority, eventually

ROLE = "1.3.6.1.4.1.50316.802.1"
RUN, DIRECTION, SPEED, UNUSED = 0x8000, 0x8001, 0x8002, 0x8040
ENDS = (ConnectionError, ssl.SSLError)

# The addresses and functions of a device, and beyond them.
REQUESTS = [
    struct.pack(">BHH", function, address, count)
    for function in (1, 2, 3, 4)
    for address, count in ((RUN, 1), (RUN, 3), (0x80F0, 16), (0x80FF, 2), (0, 1), (RUN, 0), (RUN, 65535))
] + [
    struct.pack(">BHH", 6, SPEED, 1000), struct.pack(">BHH", 6, RUN, 2), struct.pack(">BHH", 6, 0, 1),
    struct.pack(">BHHBHHH", 16, RUN, 3, 6, 0, 1, 2000), struct.pack(">BHHB", 16, RUN, 3, 5),
    struct.pack(">BHHH", 22, UNUSED, 0xF2, 0x25),
    struct.pack(">BHHHHBH", 23, UNUSED, 2, UNUSED + 1, 1, 2, 9),
    struct.pack(">BHH", 5, 0x8020, 0xFF00), struct.pack(">BHH", 5, 0x8020, 1),
    bytes([43, 14, 1, 0]), bytes([43, 14, 9, 0]), bytes([7]), bytes([8, 0, 0]), bytes([17]), bytes([100, 1]),
]


class Wire:
    """Requests over a socket, encrypted or not, after the specification alone."""

    def __init__(self, stream):
        self.stream = stream
        self.transaction = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stream.close()

    def ask(self, pdu):
        """The whole reply to a PDU, from its transaction number to its end."""
        self.transaction += 1
        self.stream.sendall(struct.pack(">HHHB", self.transaction, 0, len(pdu) + 1, 1) + pdu)
        head = self._receive(6)
        return head + self._receive(struct.unpack(">H", head[4:])[0])

    def _receive(self, size):
        data = b""
        while len(data) < size:
            more = self.stream.recv(size - len(data))
            if not more:
                raise ConnectionError("the server has closed")
            data += more
        return data


class WithDaemon(WithAuthority):
    """A daemon with Modbus Security, and clients' certificates of its authority and of another one."""

    arguments = ()

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.viewer = cls.with_role("viewer", "Viewer")
        cls.operator = cls.with_role("operator", "Operator")
        cls.daemon = Daemon(
            *cls.tls_arguments(), "--set", f"access.audit_file={cls.audit_file}", *cls.arguments,
            speed="stepped", start_s=60 * PATIENCE,
        )
        cls.addClassCleanup(cls.daemon.close)
        cls.ports = json.loads(cls.daemon.ports_file.read_text(encoding="utf-8"))

    @classmethod
    def tls_arguments(cls, **keys):
        keys = {
            "certificate": cls.server.certificate, "key": cls.server.key,
            "client_ca": cls.authority.certificate, "roles": "{Viewer: view, Operator: operate}", **keys,
        }
        return [word for key, value in keys.items() for word in ("--set", f"modbus.tls.{key}={value}")]

    @classmethod
    def with_role(cls, name, role=None, authority=None, days=1, encoding="ASN1:UTF8String"):
        lines = (f"{ROLE}={encoding}:{role}",) if role else ()
        return (authority or cls.authority).certify(name, days=days, extensions=lines)

    def context(self, certified=None):
        context = ssl.create_default_context(cafile=self.authority.certificate)
        if certified is not None:
            context.load_cert_chain(certified.certificate, certified.key)
        return context

    def secure(self, certified, context=None, port=None):
        plain = socket.create_connection((HOST, port or self.ports["modbus_tls"]), timeout=60 * PATIENCE)
        self.addCleanup(plain.close)
        stream = (context or self.context(certified)).wrap_socket(plain, server_hostname=HOST)
        self.addCleanup(stream.close)
        return Wire(stream)

    def plain(self, port=None):
        stream = socket.create_connection((HOST, port or self.ports["modbus"]), timeout=60 * PATIENCE)
        self.addCleanup(stream.close)
        return Wire(stream)

    async def pymodbus(self, certified):
        # Its own framer for TLS leaves the header out, which the specification does not; and its
        # blocking client loses bytes that TLS has decrypted already.
        client = AsyncModbusTlsClient(
            HOST, port=self.ports["modbus_tls"], framer=ModbusSocketFramer,
            sslctx=self.context(certified), timeout=20 * PATIENCE,
        )
        await client.connect()
        self.assertTrue(client.connected)
        return client

    def holding(self, address=RUN, count=3):
        reply = self.plain().ask(struct.pack(">BHH", 3, address, count))
        return list(struct.unpack(f">{count}H", reply[9:]))

    def expect_no_service(self, certified, context=None):
        with self.assertRaises(ENDS):
            self.secure(certified, context).ask(REQUESTS[0])

    def refused(self, certified):
        """That a client gets no reply, and what the log says of it."""
        logged = self.daemon.log()
        self.expect_no_service(certified)
        return eventually(
            lambda: [
                line for line in self.daemon.log()[len(logged):].splitlines()
                if "modbus_tls" in line and "dropped" in line
            ],
            "a line of the log",
        )[0]

    def expect_service(self):
        """That both ports serve."""
        self.assertEqual(self.plain().ask(REQUESTS[0])[7], 1)
        self.assertEqual(self.secure(self.viewer).ask(REQUESTS[0])[7], 1)


class Rights(WithDaemon):
    def test_pymodbus_reads_as_viewer_and_writes_as_operator(self):
        asyncio.run(self.drive_by_pymodbus())

    async def drive_by_pymodbus(self):
        viewer, operator = await self.pymodbus(self.viewer), await self.pymodbus(self.operator)
        before = self.holding()
        for refused in (
            viewer.write_register(SPEED, 777, slave=1), viewer.write_registers(RUN, [1, 1, 777], slave=1),
            viewer.write_coil(RUN, True, slave=1), viewer.write_coils(RUN, [True, True], slave=1),
        ):
            self.assertEqual((await refused).exception_code, 1)
        self.assertEqual((await viewer.read_holding_registers(RUN, 3, slave=1)).registers, before)
        self.assertEqual(self.holding(), before)
        self.assertFalse((await operator.write_registers(RUN, [0, 1, 12345], slave=1)).isError())
        for client in (viewer, operator):
            self.assertEqual((await client.read_holding_registers(RUN, 3, slave=1)).registers, [0, 1, 12345])
            self.assertEqual(len((await client.read_input_registers(RUN, 125, slave=1)).registers), 125)
        self.assertEqual(self.holding(), [0, 1, 12345])
        words = list(range(123))
        self.assertFalse((await operator.write_registers(UNUSED, words, slave=1)).isError())
        self.assertEqual((await viewer.read_holding_registers(UNUSED, 123, slave=1)).registers, words)
        self.assertEqual(self.holding(UNUSED, 123), words, "both ports have one memory")
        for client in (viewer, operator):
            await client.close()

    def test_openssl_reads(self):
        process = subprocess.Popen(
            ["openssl", "s_client", "-quiet", "-verify_return_error", "-connect",
             f"{HOST}:{self.ports['modbus_tls']}", "-CAfile", self.authority.certificate,
             "-cert", self.viewer.certificate, "-key", self.viewer.key],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )
        try:
            process.stdin.write(bytes.fromhex("0007000000060103") + struct.pack(">HH", RUN, 3))
            process.stdin.flush()
            reply = process.stdout.read(15)
        finally:
            process.kill()
            process.communicate()
        self.assertEqual(reply, struct.pack(">HHHBBB3H", 7, 0, 9, 1, 3, 6, *self.holding()))

    def test_replies_are_those_of_the_plain_port(self):
        with self.plain() as plain, self.secure(self.operator) as secure:
            for pdu in REQUESTS:
                self.assertEqual(secure.ask(pdu), plain.ask(pdu), pdu.hex())

    def test_a_role_decides_by_function(self):
        writing = {5, 6, 15, 16, 22, 23}
        nobody = self.with_role("nobody")
        guest = self.with_role("guest", "Guest")
        both = self.with_role("both", "Viewer, Operator")
        with self.plain() as plain, self.secure(self.viewer) as viewer:
            with self.secure(nobody) as none, self.secure(guest) as unknown, self.secure(both) as one:
                before = self.holding()
                for pdu in REQUESTS:
                    for wire in (none, unknown, one):
                        self.assertEqual(wire.ask(pdu)[7:], bytes([pdu[0] | 0x80, 1]), pdu.hex())
                    if pdu[0] in writing:
                        self.assertEqual(viewer.ask(pdu)[7:], bytes([pdu[0] | 0x80, 1]), pdu.hex())
                    else:
                        self.assertEqual(viewer.ask(pdu)[7:], plain.ask(pdu)[7:], pdu.hex())
                self.assertEqual(self.holding(), before)

    def test_refusals_are_logged_once_and_commands_audited(self):
        # Lines that clients cause have a limit a second, which other tests may have reached: one client
        # in two seconds.
        expected, due = {}, time.monotonic()

        def refuse():
            nonlocal due
            if time.monotonic() >= due:
                due = time.monotonic() + 2
                viewer = self.secure(self.viewer)
                for _ in range(3):
                    self.assertEqual(viewer.ask(struct.pack(">BHH", 6, SPEED, 5))[7:], b"\x86\x01")
                peer = "{}:{}".format(*viewer.stream.getsockname())
                who = f'{peer} (certificate CN=viewer, role "Viewer")'
                expected[peer] = f"refused {who}: function 6 needs the right operate"
            log = self.daemon.log()
            return next((each for each in expected.items() if each[1] in log), None)

        peer, line = eventually(refuse, "a line of the log", 60)
        self.secure(self.operator).ask(struct.pack(">BHH", 6, SPEED, 6))

        def written():
            lines = self.audit_file.read_text(encoding="utf-8").splitlines()
            return [each for each in map(json.loads, lines) if each["wire"] == "modbus_tls"]

        done = eventually(
            lambda: [each for each in written() if each["request"].endswith("0680020006")], "an entry"
        )[0]
        self.assertEqual(done["identity"], 'certificate CN=operator, role "Operator"')
        self.assertNotIn("needs", done.get("outcome", ""))
        refused = [each for each in written() if each["peer"] == peer]
        self.assertEqual(len(refused), 3)
        self.assertEqual(refused[0]["identity"], 'certificate CN=viewer, role "Viewer"')
        self.assertEqual(refused[0]["outcome"], "function 6 needs the right operate; it has view")
        self.assertEqual(self.daemon.log().count(line), 1)

    def test_the_server_conforms_over_tls(self):
        aprsim = [find_binary("aprsim"), "--ca", self.authority.certificate]
        own = ["--certificate", self.operator.certificate, "--key", self.operator.key]
        daemon = Daemon(*self.tls_arguments(), start_s=60 * PATIENCE)  # whose time passes
        self.addCleanup(daemon.close)
        ports = json.loads(daemon.ports_file.read_text(encoding="utf-8"))
        address = f"{HOST}:{ports['modbus_tls']}"

        def conform(*words):
            return subprocess.run(
                [*aprsim, *words], capture_output=True, text=True, stdin=subprocess.DEVNULL,
                timeout=200 * PATIENCE, check=False,
            )

        done = conform(*own, "conform", "modbus", address, "--secure", "--allow-motion", "--json")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        rules = [line for line in lines if "verdict" in line]
        self.assertGreater(len(rules), 20)
        self.assertEqual({line["verdict"] for line in rules}, {"pass"})
        for words in (("conform", "modbus", address, "--secure"), (*own, "conform", "modbus", address)):
            done = conform(*words)
            self.assertNotEqual(done.returncode, 0, "no certificate, or no TLS")
        self.assertEqual(conform(*own, "conform", "modbus", "--secure").returncode, 2, "no address")

    def test_metrics_count_the_port_by_itself(self):
        with self.secure(self.viewer) as viewer:
            viewer.ask(REQUESTS[0])
            viewer.ask(struct.pack(">BHH", 6, SPEED, 5))
            with socket.create_connection((HOST, self.ports["web"]), timeout=60 * PATIENCE) as web:
                web.sendall(f"GET /metrics HTTP/1.0\r\nHost: {HOST}:{self.ports['web']}\r\n\r\n".encode())
                text = b"".join(iter(lambda: web.recv(65536), b"")).decode()
        values = dict(line.rsplit(" ", 1) for line in text.splitlines() if 'wire="modbus_tls"' in line)
        self.assertGreaterEqual(float(values['aprsim_connections{wire="modbus_tls"}']), 1)
        self.assertGreaterEqual(float(values['aprsim_requests_total{wire="modbus_tls"}']), 2)
        self.assertGreaterEqual(float(values['aprsim_request_errors_total{wire="modbus_tls"}']), 1)
        self.assertIn('aprsim_tls_failures_total{wire="modbus_tls"}', values)

    def test_the_server_says_goodbye(self):
        wire = self.secure(self.viewer)
        wire.ask(REQUESTS[0])
        # A length that cannot be: the rest of the stream has no frame.
        wire.stream.sendall(bytes([0, 1, 0, 0, 0xFF, 0xFF, 1, 3]))
        with self.assertRaises(ENDS):
            wire.ask(REQUESTS[0])
        self.expect_service()


class CommandLine(WithDaemon):
    """`aprsim conveyor --secure`."""

    def conveyor(self, certified, *words, ports=True):
        own = ["--ca", self.authority.certificate]
        if certified:
            own += ["--certificate", certified.certificate, "--key", certified.key]
        if ports:
            own += ["--ports-file", str(self.daemon.ports_file)]
        return subprocess.run(
            [find_binary("aprsim"), *own, "conveyor", *words], capture_output=True, text=True,
            stdin=subprocess.DEVNULL, timeout=60 * PATIENCE, check=False,
        )

    def test_status_is_that_of_the_plain_port(self):
        plain = self.conveyor(None, "status", "--json")
        secure = self.conveyor(self.viewer, "status", "--secure", "--json")
        self.assertEqual(secure.returncode, 0, secure.stderr)
        self.assertEqual(json.loads(secure.stdout), json.loads(plain.stdout))

    def test_the_role_decides(self):
        before = self.holding()
        refused = self.conveyor(self.viewer, "set", "--speed", "37%", "--secure")
        self.assertEqual(refused.returncode, 1, refused.stderr)
        self.assertIn("cannot write", refused.stderr)
        self.assertIn("the role in the certificate", refused.stderr)
        self.assertEqual(self.holding(), before)
        done = self.conveyor(
            self.operator, "set", "--speed", "37%", "--direction", "reverse", "--secure", "--json"
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        written = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([line["register"] for line in written], ["direction", "speed", "run"])
        self.assertEqual(self.holding(), [1, 0, round(0.37 * 32768)])
        self.assertEqual(self.conveyor(self.operator, "set", "--stop", "--secure").returncode, 0)
        self.assertEqual(self.holding()[0], 0)

    def test_a_port_of_its_own(self):
        port = str(self.ports["modbus_tls"])
        done = self.conveyor(self.viewer, "status", "--secure", "--modbus-port", port, ports=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_clients_that_are_not_served(self):
        none = self.conveyor(None, "status", "--secure")
        self.assertEqual(none.returncode, 2, none.stderr)
        self.assertIn("certificate", none.stderr)
        stranger = self.with_role("odd", "Operator", authority=Authority(str(self.folder), "odd_one"))
        for words in (("status",), ("set", "--stop")):
            done = self.conveyor(stranger, *words, "--secure")
            self.assertEqual(done.returncode, 3, done.stderr)
        # A server without TLS.
        plain = str(self.ports["modbus"])
        done = self.conveyor(self.viewer, "status", "--secure", "--modbus-port", plain, ports=False)
        self.assertEqual(done.returncode, 3, done.stderr)


class Handshakes(WithDaemon):
    def test_certificates_that_are_not_taken(self):
        stranger = self.with_role("stranger", "Operator", authority=Authority(str(self.folder), "other"))
        late = self.with_role("late", "Operator", days=-1)
        # A second role under a number that is then changed to the role's.
        two = self.authority.certify("two", extensions=(
            f"{ROLE}=ASN1:UTF8String:Viewer", f"{ROLE[:-1]}2=ASN1:UTF8String:Operator",
        ))
        number = bytes.fromhex("060b2b060104018389 0c8622")
        self.authority.alter(two, number + b"\x02", number + b"\x01")
        other = self.with_role("printable", "Operator", encoding="ASN1:PRINTABLESTRING")
        for certified, words in (
            (None, "no TLS handshake"),
            (stranger, "its certificate is not taken"),
            (late, "its certificate is not taken: certificate has expired"),
            (two, "the role in its certificate is not the only one"),
            (other, "the role in its certificate is no UTF8String in DER"),
        ):
            self.assertIn(words, self.refused(certified))
        self.expect_service()

    def test_versions_and_ciphers(self):
        def limited(least, most, ciphers=None):
            context = self.context(self.viewer)
            context.set_ciphers(ciphers or "DEFAULT:@SECLEVEL=0")
            context.minimum_version, context.maximum_version = least, most
            return context

        version = ssl.TLSVersion
        self.expect_no_service(self.viewer, limited(version.TLSv1, version.TLSv1_1))
        # no HMAC-SHA-1.
        without = limited(version.TLSv1_2, version.TLSv1_2, "ECDHE-ECDSA-AES128-SHA")
        self.expect_no_service(self.viewer, without)
        for least, cipher in (
            (version.TLSv1_2, "ECDHE-ECDSA-AES128-GCM-SHA256"),
            (version.TLSv1_3, None),
        ):
            with self.secure(self.viewer, limited(least, least, cipher)) as wire:
                wire.ask(REQUESTS[0])
                self.assertEqual(wire.stream.version(), least.name.replace("_", "."))
                if cipher:
                    self.assertEqual(wire.stream.cipher()[0], cipher)

    def test_garbage_costs_its_sender_alone(self):
        dice = random.Random(7)
        hello = bytes.fromhex("16030100c8010000c40303")
        for first in (
            b"GET / HTTP/1.1\r\n\r\n", bytes.fromhex("000100000006010380000003"), bytes(300),
            b"\x15\x03\x03\x00\x02\x02\x28", hello + dice.randbytes(300),
            *(dice.randbytes(dice.randrange(1, 3000)) for _ in range(40)),
        ):
            with socket.create_connection((HOST, self.ports["modbus_tls"]), timeout=60 * PATIENCE) as client:
                try:
                    client.sendall(first)
                    client.shutdown(socket.SHUT_WR)
                    while client.recv(4096):
                        pass
                except ConnectionError:
                    pass
        self.expect_service()

    def test_half_open_handshakes_cost_nothing_else(self):
        hello = bytes.fromhex("16030100c8")
        stalled = []
        for i in range(64):
            client = socket.create_connection((HOST, self.ports["modbus_tls"]), timeout=60 * PATIENCE)
            self.addCleanup(client.close)
            if i % 2:
                client.sendall(hello)
            stalled.append(client)
        with self.plain() as plain:
            for _ in range(50):
                self.assertEqual(plain.ask(REQUESTS[0])[7], 1)
        self.expect_service()
        for client in stalled:
            try:
                while client.recv(4096):
                    pass
            except ConnectionError:
                pass
        self.assertIn("no TLS handshake within 5000 ms", self.daemon.log())
        self.expect_service()

    def test_more_half_open_handshakes_than_connections(self):
        for _ in range(200):
            client = socket.create_connection((HOST, self.ports["modbus_tls"]), timeout=60 * PATIENCE)
            self.addCleanup(client.close)
        with self.plain() as plain:
            for _ in range(50):
                self.assertEqual(plain.ask(REQUESTS[0])[7], 1)
        # They have their time, and then there is room again.
        def served():
            try:
                return self.secure(self.viewer).ask(REQUESTS[0])[7] == 1
            except (*ENDS, OSError):
                return False

        eventually(served, "a client with a certificate is served", 60)

    def test_files_are_read_again(self):
        renewed = self.authority.certify("renewed", f"IP:{HOST}")

        def name():
            with self.secure(self.viewer) as wire:
                wire.ask(REQUESTS[0])
                return wire.stream.getpeercert()["subject"][0][0][1]

        old = self.secure(self.viewer)
        self.assertEqual(name(), "server")
        for file, new in ((self.server.certificate, renewed.certificate), (self.server.key, renewed.key)):
            pathlib.Path(file).write_bytes(pathlib.Path(new).read_bytes())
        self.daemon.process.send_signal(signal.SIGHUP)
        eventually(lambda: name() == "renewed", "the certificate is read again")
        self.assertEqual(old.ask(REQUESTS[0])[7], 1, "open connections stay")


class Files(WithDaemon):
    def check(self, **keys):
        words = self.tls_arguments(**keys)
        for key in (key for key, value in keys.items() if value is None):
            at = words.index(f"modbus.tls.{key}=None")
            del words[at - 1 : at + 1]
        return subprocess.run(
            [find_binary("aprsimd"), "--check", *words], capture_output=True, text=True,
            stdin=subprocess.DEVNULL, timeout=60 * PATIENCE, check=False,
        )

    def test_each_mistake_is_named(self):
        late = self.authority.certify("late", days=-1)
        for keys, words in (
            ({"key": None}, "certificate, key and client_ca together"),
            ({"client_ca": None}, "certificate, key and client_ca together"),
            ({"roles": "{}"}, "roles together with certificate"),
            ({"roles": "{Viewer: inject}"}, "modbus.tls.roles.Viewer"),
            ({"min_version": "1.1"}, "modbus.tls.min_version"),
            ({"certificate": "/nonexistent"}, "modbus.tls.certificate: cannot read /nonexistent: No such"),
            ({"certificate": late.certificate, "key": late.key}, "modbus.tls.certificate: the certificate in"),
            ({"key": self.viewer.key}, "modbus.tls.key: "),
            ({"client_ca": self.server.key}, "modbus.tls.client_ca: "),
        ):
            done = self.check(**keys)
            self.assertNotEqual(done.returncode, 0, keys)
            self.assertIn(words, done.stderr)
        for keys in ({}, {"min_version": "1.3"}, {"roles": "{}", "no_role": "view"}):
            done = self.check(**keys)
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_the_example_is_a_configuration(self):
        example = pathlib.Path(__file__).resolve().parents[3] / "clients" / "examples" / "modbus_security.yaml"
        files = self.tls_arguments()
        roles = files.index(next(word for word in files if word.startswith("modbus.tls.roles")))
        del files[roles - 1 : roles + 1]
        done = subprocess.run(
            [find_binary("aprsimd"), "--config", str(example), *files, "--check"], capture_output=True,
            text=True, stdin=subprocess.DEVNULL, timeout=60 * PATIENCE, check=False,
        )
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_taken_port_is_named(self):
        with self.assertRaises(AprsimError) as failed:
            with socket.create_server((HOST, 0)) as taken:
                port = taken.getsockname()[1]
                # A port file's free ports come from --any-port, which a later --set replaces.
                done = subprocess.run(
                    [find_binary("aprsimd"), "--speed", "stepped", *self.tls_arguments(port=port),
                     *(word for key in ("crcl.ports.fanuc", "crcl.ports.motoman", "vision.ports.fanuc",
                                        "vision.ports.motoman", "cameras.port", "modbus.port", "grpc.port",
                                        "web.port") for word in ("--set", f"{key}=0"))],
                    capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=60 * PATIENCE,
                    check=False,
                )
                raise AprsimError(done.stdout + done.stderr)
        self.assertIn("modbus.tls.port", str(failed.exception))

    def test_certificates_without_a_role_have_the_configured_rights(self):
        arguments = self.tls_arguments(no_role="view", min_version="1.3")
        with Daemon(*arguments, speed="stepped", start_s=60 * PATIENCE) as daemon:
            port = json.loads(daemon.ports_file.read_text(encoding="utf-8"))["modbus_tls"]
            nobody, guest = self.with_role("nobody"), self.with_role("guest", "Guest")
            read, write = REQUESTS[0], struct.pack(">BHH", 6, SPEED, 5)
            with self.secure(nobody, port=port) as wire:
                self.assertEqual(wire.ask(read)[7], 1)
                self.assertEqual(wire.ask(write)[7:], bytes([0x86, 1]))
                self.assertEqual(wire.stream.version(), "TLSv1.3")
            with self.secure(guest, port=port) as wire:
                self.assertEqual(wire.ask(read)[7:], bytes([0x81, 1]))
            old = self.context(self.viewer)
            old.maximum_version = ssl.TLSVersion.TLSv1_2
            with self.assertRaises(ENDS):
                self.secure(self.viewer, old, port=port)


class Maps(WithDaemon):
    SERVERS = """
modbus_servers:
  - name: line
    registers:
      - {area: coil, address: 0, signal: belt.run, access: write}
      - {area: holding, address: 0, signal: belt.speed_setting_m_s, scale: 0.001, access: write}
"""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="aprsim-modbus-scene-")
        cls.addClassCleanup(folder.cleanup)
        scenes = pathlib.Path(__file__).resolve().parents[3] / "world" / "scenes"
        scene = pathlib.Path(folder.name) / "aprs_line.yaml"
        text = (scenes / "aprs.yaml").read_text(encoding="utf-8")
        scene.write_text(text + cls.SERVERS, encoding="utf-8")
        for types in scenes.glob("*types*.yaml"):
            (scene.parent / types.name).write_bytes(types.read_bytes())
        cls.arguments = ("--scene", str(scene))
        super().setUpClass()

    def test_servers_of_the_scene_have_a_port_of_their_own(self):
        self.assertNotEqual(self.ports["modbus_tls.line"], self.ports["modbus.line"])
        speed = struct.pack(">BHH", 3, 0, 1)
        with self.secure(self.viewer, port=self.ports["modbus_tls.line"]) as viewer:
            with self.plain(self.ports["modbus.line"]) as plain:
                write = struct.pack(">BHH", 6, 0, 120)
                self.assertEqual(viewer.ask(write)[7:], bytes([0x86, 1]))
                with self.secure(self.operator, port=self.ports["modbus_tls.line"]) as operator:
                    self.assertEqual(operator.ask(write)[7:], write)
                self.assertEqual(viewer.ask(speed)[7:], bytes([3, 2, 0, 120]))
                self.assertEqual(plain.ask(speed)[7:], bytes([3, 2, 0, 120]))
                beyond = struct.pack(">BHH", 3, 7, 1)
                self.assertEqual(viewer.ask(beyond)[7:], plain.ask(beyond)[7:])


if __name__ == "__main__":
    unittest.main()
