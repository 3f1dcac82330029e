"""Every role against every call, over TLS; wrong, expired and missing credentials; certificates of our
own authority; what is kept of it all."""

import importlib
import json
import os
import pathlib
import pkgutil
import signal
import socket
import ssl
import subprocess
import tempfile
import unittest
import urllib.error
import urllib.request

import aprsim.crcl.v1
import aprsim.v1
import grpc
from aprsim import Cell, Daemon, Refused, Unreachable, aio
from aprsim.binaries import find_binary
from aprsim.crcl.v1 import commands_pb2, robot_service_pb2, robot_service_pb2_grpc, status_pb2
from authority import Authority
from web_socket import Page as PageSocket
from web_socket import page_messages
from with_authority import HOST, PATIENCE, WithAuthority, eventually

ROLES = ("view", "operate", "inject", "admin")
REFUSALS = (grpc.StatusCode.UNAUTHENTICATED, grpc.StatusCode.PERMISSION_DENIED)


def roles_of_calls():
    """The one table, as it stands in the sources."""
    table = {}
    source = pathlib.Path(__file__).resolve().parents[3] / "protocols" / "access" / "call_roles.cpp"
    for line in source.read_text(encoding="utf-8").splitlines():
        if line.strip().startswith("CallRole{"):
            call, role = line.strip().removeprefix("CallRole{").split("}")[0].split(", Role::k")
            table[call.strip('"')] = role.lower()
    return table


def may(role, needed):
    """Whether a role, None = no credentials, may what needs another one."""
    order = ("none", *ROLES)
    return order.index(role or "view") >= order.index(needed)


def methods():
    """Every method of the services that the Python package knows."""
    all_methods = {}
    for package in (aprsim.v1, aprsim.crcl.v1):
        for module in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
            if module.name.endswith("_pb2"):
                file = importlib.import_module(module.name).DESCRIPTOR
                for service in file.services_by_name.values():
                    for method in service.methods:
                        all_methods[f"{service.full_name}/{method.name}"] = method
    return all_methods


class WithTokens(WithAuthority):
    """Also an access file with a token for each role, and a daemon."""

    arguments = ()

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.access_file = str(cls.folder / "access")
        cls.tokens = {role: cls.add_token(role, role) for role in ROLES}
        cls.daemon = cls.start(*cls.arguments)
        cls.context = ssl.create_default_context(cafile=cls.authority.certificate)

    @classmethod
    def start(cls, *arguments):
        daemon = Daemon(
            "--set", f"tls.certificate={cls.server.certificate}", "--set", f"tls.key={cls.server.key}",
            "--set", f"access.file={cls.access_file}", "--set", f"access.audit_file={cls.audit_file}",
            *arguments, speed="stepped", start_s=60 * PATIENCE,
        )
        cls.addClassCleanup(daemon.close)
        cls.ports = json.loads(daemon.ports_file.read_text(encoding="utf-8"))
        return daemon

    @classmethod
    def token_command(cls, *arguments):
        done = subprocess.run(
            [find_binary("aprsimd"), "token", *arguments, "--file", cls.access_file],
            capture_output=True, text=True, timeout=60 * PATIENCE, check=False,
        )
        if done.returncode != 0:
            raise AssertionError(done.stderr)
        return done.stdout.strip()

    @classmethod
    def add_token(cls, name, role, *more):
        return cls.token_command("add", name, "--role", role, *more)

    def channel(self, certified=None, ca=None):
        def read(path):
            return pathlib.Path(path).read_bytes() if path else None

        credentials = grpc.ssl_channel_credentials(
            read(ca or self.authority.certificate),
            read(certified and certified.key), read(certified and certified.certificate),
        )
        channel = grpc.secure_channel(
            f"{HOST}:{self.ports['grpc']}", credentials, [("grpc.use_local_subchannel_pool", 1)]
        )
        self.addCleanup(channel.close)
        return channel

    def call(self, channel, name, token=None, request=b""):
        """The status of any method with an empty request, of a stream up to its first answer; of one
        that waits for something to happen, that its time is over."""
        method = methods()[name]
        kind = ("stream" if method.client_streaming else "unary") + (
            "_stream" if method.server_streaming else "_unary"
        )
        ask = getattr(channel, kind)(f"/{name}")
        metadata = [("authorization", f"Bearer {token}")] if token is not None else []
        sent = iter([request]) if method.client_streaming else request
        try:
            if method.server_streaming:
                answers = ask(sent, timeout=3 * PATIENCE, metadata=metadata)
                next(answers, None)
                answers.cancel()
            else:
                ask(sent, timeout=3 * PATIENCE, metadata=metadata)
        except grpc.RpcError as error:
            return error.code(), error.details()
        return grpc.StatusCode.OK, ""

    def expect_refusals(self, channel, role, token=None):
        """That exactly those calls are refused that need more than the role."""
        table = roles_of_calls()
        for name in methods():
            code, details = self.call(channel, name, token)
            if may(role, table[name]):
                self.assertNotIn(code, REFUSALS, f"{role} {name}: {details}")
            else:
                self.assertIn(code, REFUSALS, f"{role} {name}: {details}")
                self.assertIn(f"needs the role {table[name]}", details)
                known = token is not None or "certificate" in details and "has" in details
                self.assertEqual(code == grpc.StatusCode.PERMISSION_DENIED, bool(known), details)

    def applied(self):
        """Commands that the cell has taken so far."""
        with self.cell("view") as cell:
            return cell.snapshot().message.applied_ticket

    def cell(self, role, **options):
        path = self.folder / f"{role}.token"
        path.write_text(self.tokens[role] + "\n", encoding="utf-8")
        return Cell.connect(
            self.daemon.ports_file, token_file=path, ca=self.authority.certificate, **options
        )


class Matrix(WithTokens):
    def test_it_has_every_call_of_the_daemon(self):
        calls = {
            call for call in roles_of_calls()
            if call.startswith("aprsim.") and "ViewerRequest" not in call
        }
        self.assertEqual(set(methods()), calls)

    def test_a_robot_obeys_who_may_command_it(self):
        robots = robot_service_pb2_grpc.RobotServiceStub(self.channel())
        options = robot_service_pb2.SessionOptions(robot="fanuc")

        def execute(role, number):
            command = commands_pb2.CommandInstance(
                command=commands_pb2.Command(command_id=number, init_canon={})
            )
            return robots.Execute(
                robot_service_pb2.ExecuteRequest(options=options, command=command),
                timeout=60 * PATIENCE, metadata=[("authorization", f"Bearer {self.tokens[role]}")],
            ).status.command_status

        def status(role):
            metadata = [("authorization", f"Bearer {self.tokens[role]}")] if role else []
            answer = robots.GetStatus(
                robot_service_pb2.GetStatusRequest(options=options), timeout=60 * PATIENCE,
                metadata=metadata,
            )
            return answer.status.command_status

        with self.cell("operate") as cell:
            cell.resume()
            done = execute("operate", 71)
            self.assertEqual(done.command_state, status_pb2.COMMAND_STATE_DONE)
            with self.assertRaises(grpc.RpcError) as refused:
                execute("view", 72)
            self.assertEqual(refused.exception.code(), grpc.StatusCode.PERMISSION_DENIED)
            for role in (None, "view"):
                self.assertEqual(status(role).command_id, 71)
            cell.pause()
        line = '"aprsim.crcl.v1.RobotService/Execute"'
        eventually(lambda: line in self.audit_file.read_text(encoding="utf-8"), "it is written down")

    def test_every_role_and_every_call(self):
        channel = self.channel()
        for role in ROLES:
            self.expect_refusals(channel, role, self.tokens[role])

    def test_without_credentials_there_is_only_looking(self):
        before = self.applied()
        self.expect_refusals(self.channel(), None)
        self.assertEqual(self.applied(), before)

    def test_refused_calls_change_nothing(self):
        before = self.applied()
        channel = self.channel()
        for role in (None, "view"):
            for name in methods():
                if not may(role, roles_of_calls()[name]):
                    self.call(channel, name, role and self.tokens[role])
        self.assertEqual(self.applied(), before)

    def test_wrong_and_expired_tokens_are_worse_than_none(self):
        late = self.add_token("late", "admin", "--expires", "2099-01-01")
        text = pathlib.Path(self.access_file).read_text(encoding="utf-8")
        pathlib.Path(self.access_file).write_text(text.replace("2099-01-01", "2020-01-01"), encoding="utf-8")
        self.daemon.process.send_signal(signal.SIGHUP)
        channel = self.channel()
        eventually(
            lambda: "has expired" in self.call(channel, "aprsim.v1.ControlService/Pause", late)[1],
            "the file is read again",
        )
        for name in methods():
            code, details = self.call(channel, name, late)
            self.assertEqual(code, grpc.StatusCode.UNAUTHENTICATED, name)
            self.assertIn("token late has expired", details)
        wrong = [self.tokens["admin"] + "0", self.tokens["admin"][:-1], "", "aprsim_"]
        for token in wrong:
            code, details = self.call(channel, "aprsim.v1.TelemetryService/GetSnapshot", token)
            self.assertEqual(code, grpc.StatusCode.UNAUTHENTICATED, details)
            self.assertIn("not one of this daemon", details)
        self.assertIn("is refused: authorization: the token is not one of this daemon", self.daemon.log())
        for token in (*self.tokens.values(), late):
            self.assertNotIn(token, self.daemon.log())
        # Then the address waits with further guesses, and never with a right token.
        def guess():
            return self.call(channel, "aprsim.v1.ControlService/Pause", "guess")[0]

        eventually(lambda: guess() == grpc.StatusCode.RESOURCE_EXHAUSTED, "the address waits")
        code, details = self.call(channel, "aprsim.v1.ControlService/Pause", self.tokens["admin"])
        self.assertEqual(code, grpc.StatusCode.OK, details)

        def applied():
            with Cell.connect(self.daemon.ports_file, ca=self.authority.certificate) as cell:
                return cell.snapshot().message.applied_ticket

        before = applied()
        for name in methods():
            code, _ = self.call(channel, name, "guess")
            self.assertIn(
                code, (grpc.StatusCode.UNAUTHENTICATED, grpc.StatusCode.RESOURCE_EXHAUSTED), name
            )
        self.assertEqual(applied(), before)

    def test_a_token_is_made_and_removed_while_the_daemon_runs(self):
        token = self.add_token("guest", "operate")
        channel = self.channel()
        pause = "aprsim.v1.ControlService/Pause"
        self.daemon.process.send_signal(signal.SIGHUP)
        eventually(lambda: "are reloaded" in self.daemon.log(), "the file is read again")
        self.assertEqual(self.call(channel, pause, token)[0], grpc.StatusCode.OK)
        self.token_command("remove", "guest")
        self.daemon.process.send_signal(signal.SIGHUP)
        eventually(
            lambda: self.call(channel, pause, token)[0] != grpc.StatusCode.OK, "it is forgotten"
        )


class Encryption(WithTokens):
    arguments = ()

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.token_command("add", "operator.lab", "--certificate", "--role", "operate")
        cls.token_command("add", "injector", "--certificate", "--role", "inject")
        cls.daemon.close()
        cls.client_ca = Authority(str(cls.folder), "clients")
        cls.daemon = cls.start("--set", f"tls.client_ca={cls.client_ca.certificate}")

    def test_a_name_in_a_certificate_has_a_role(self):
        for role, certified in (
            ("operate", self.client_ca.certify("somebody", "DNS:operator.lab")),
            ("inject", self.client_ca.certify("injector")),
            ("view", self.client_ca.certify("stranger", "DNS:elsewhere.lab")),
        ):
            self.expect_refusals(self.channel(certified), role)

    def test_certificates_of_others_and_expired_ones_get_no_connection(self):
        status = "aprsim.v1.TelemetryService/GetSnapshot"
        for certified, cause in (
            (Authority(str(self.folder), "foreign").certify("injector"), "unable to get local issuer"),
            (self.client_ca.certify("late injector", days=-1), "expired"),
        ):
            code, _ = self.call(self.channel(certified), status)
            self.assertEqual(code, grpc.StatusCode.UNAVAILABLE)
            eventually(lambda c=cause: "its certificate is not taken: " in self.daemon.log()
                       and c in self.daemon.log(), cause)

    def test_a_daemon_that_others_certify_is_not_trusted(self):
        other = Authority(str(self.folder), "other")
        code, _ = self.call(self.channel(ca=other.certificate), "aprsim.v1.TelemetryService/GetSnapshot")
        self.assertEqual(code, grpc.StatusCode.UNAVAILABLE)

    def test_unencrypted_clients_are_refused(self):
        with self.assertRaises(Unreachable):
            Cell.connect(self.daemon.ports_file)
        with socket.create_connection((HOST, self.ports["web"]), timeout=20 * PATIENCE) as plain:
            plain.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
            self.assertNotIn(b"html", plain.recv(1 << 16))
        eventually(lambda: "no TLS handshake" in self.daemon.log(), "a line in the log")

    def test_old_versions_of_tls_are_refused(self):
        for port in (self.ports["grpc"], self.ports["web"]):
            old = ssl.create_default_context(cafile=self.authority.certificate)
            old.set_ciphers("ALL:@SECLEVEL=0")
            old.minimum_version = ssl.TLSVersion.TLSv1
            old.maximum_version = ssl.TLSVersion.TLSv1_1
            with socket.create_connection((HOST, port), timeout=20 * PATIENCE) as plain:
                with self.assertRaises(ssl.SSLError):
                    old.wrap_socket(plain, server_hostname=HOST)

    def test_a_handshake_that_never_ends_holds_up_nobody(self):
        with socket.create_connection((HOST, self.ports["grpc"])), \
             socket.create_connection((HOST, self.ports["web"])) as silent:
            silent.sendall(b"\x16\x03\x01")
            with self.cell("operate") as cell:
                cell.pause()
                cell.step(3)

    def test_streams_and_steps_in_python(self):
        certified = self.client_ca.certify("injector")
        with Cell.connect(
            self.daemon.ports_file, ca=self.authority.certificate,
            certificate=certified.certificate, key=certified.key,
        ) as cell:
            cell.pause()
            before = cell.snapshot().step
            self.assertEqual(cell.step(5).step, before + 5)
            seen = [snapshot for snapshot, _ in zip(cell.stream(hz=100), range(3))]
            self.assertEqual(len(seen), 3)
            with self.assertRaises(Refused) as refused:
                cell.reset()
            self.assertEqual(refused.exception.code, "PERMISSION_DENIED")

    def test_asyncio(self):
        import asyncio

        async def run():
            path = self.folder / "operate.token"
            path.write_text(self.tokens["operate"], encoding="utf-8")
            async with await aio.Cell.connect(
                self.daemon.ports_file, ca=self.authority.certificate, token_file=path
            ) as cell:
                await cell.pause()
                return (await cell.step(2)).step

        self.assertGreater(asyncio.run(run()), 0)

    def test_the_command_line(self):
        token = self.folder / "operate.token"
        token.write_text(self.tokens["operate"], encoding="utf-8")
        files = ["--ports-file", str(self.daemon.ports_file), "--ca", self.authority.certificate]

        def run(*arguments, **environment):
            return subprocess.run(
                [find_binary("aprsim"), *arguments], capture_output=True, text=True,
                timeout=60 * PATIENCE, env={**os.environ, **environment}, check=False,
            )

        self.assertEqual(run("pause", *files, "--token-file", str(token)).returncode, 0)
        self.assertEqual(run("step", "2", *files, "--token-file", str(token)).returncode, 0)
        refused = run("step", "2", *files)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("needs the role operate", refused.stderr)
        # The token comes from the environment, then a certificate is used.
        certified = self.client_ca.certify("injector")
        done = run(
            "step", "1", APRSIM_PORTS_FILE=str(self.daemon.ports_file),
            APRSIM_CA=self.authority.certificate, APRSIM_CERTIFICATE=certified.certificate,
            APRSIM_KEY=certified.key,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(run("status", *files[:2]).returncode, 3, "it is encrypted")
        self.assertEqual(run("status", *files, "--certificate", certified.certificate).returncode, 2)
        self.assertEqual(run("status", *files[:3], "/nonexistent").returncode, 2)

    def test_certificates_are_renewed_while_the_daemon_runs(self):
        def serial():
            with socket.create_connection((HOST, self.ports["web"]), timeout=20 * PATIENCE) as plain:
                with self.context.wrap_socket(plain, server_hostname=HOST) as secure:
                    return secure.getpeercert()["serialNumber"]

        before = serial()
        self.authority.certify("server", f"IP:{HOST},DNS:localhost")  # in the same files
        self.assertEqual(serial(), before)
        self.daemon.process.send_signal(signal.SIGHUP)
        eventually(lambda: serial() != before, "the new certificate is shown")
        pathlib.Path(self.server.certificate).write_text("nonsense", encoding="utf-8")
        self.daemon.process.send_signal(signal.SIGHUP)
        eventually(lambda: "not reloaded: tls.certificate" in self.daemon.log(), "it is told")
        self.assertNotEqual(serial(), before)
        self.authority.certify("server", f"IP:{HOST},DNS:localhost")


class Required(WithTokens):
    """A daemon that asks for certificates of clients."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.daemon.close()
        cls.client_ca = Authority(str(cls.folder), "clients")
        cls.daemon = cls.start(
            "--set", f"tls.client_ca={cls.client_ca.certificate}",
            "--set", "tls.client_certificates=required",
        )

    def test_without_a_certificate_no_call_is_heard(self):
        channel = self.channel()
        for name in methods():
            code, _ = self.call(channel, name, self.tokens["admin"])
            self.assertEqual(code, grpc.StatusCode.UNAVAILABLE, name)
        with socket.create_connection((HOST, self.ports["web"]), timeout=20 * PATIENCE) as plain:
            with self.assertRaises(OSError):
                with self.context.wrap_socket(plain, server_hostname=HOST) as page:
                    page.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
                    if not page.recv(1):
                        raise OSError("closed")

    def test_a_certificate_lets_look_and_a_token_command(self):
        channel = self.channel(self.client_ca.certify("somebody"))
        pause = "aprsim.v1.ControlService/Pause"
        self.assertEqual(
            self.call(channel, "aprsim.v1.TelemetryService/GetSnapshot")[0], grpc.StatusCode.OK
        )
        self.assertEqual(self.call(channel, pause)[0], grpc.StatusCode.PERMISSION_DENIED)
        self.assertEqual(self.call(channel, pause, self.tokens["operate"])[0], grpc.StatusCode.OK)


class Page(WithTokens):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.messages = page_messages()

    def page(self):
        page = PageSocket(self.messages, self.ports["web"], self.context, 20 * PATIENCE)
        self.addCleanup(page.close)
        return page

    def test_every_role_and_every_request(self):
        table = roles_of_calls()
        kinds = [f.name for f in self.messages.ViewerRequest.DESCRIPTOR.oneofs_by_name["body"].fields]
        for role in (None, *ROLES):
            page = self.page()
            if role:
                outcome = page.ask(authenticate={"token": self.tokens[role]})
                self.assertTrue(outcome.ok, outcome.message)
            for kind in kinds:
                if kind == "authenticate":
                    continue
                needed = table[f"aprsim.v1.ViewerRequest/{kind}"]
                outcome = page.ask(**{kind: {}})
                refused = outcome.field == "permission"
                self.assertEqual(refused, not may(role, needed), f"{role} {kind}: {outcome.message}")
                if refused:
                    self.assertFalse(outcome.ok)
                    self.assertIn(f"needs the role {needed}", outcome.message)

    def test_pages_of_http(self):
        def status(path, token=None):
            request = urllib.request.Request(f"https://{HOST}:{self.ports['web']}{path}")
            if token is not None:
                request.add_header("Authorization", f"Bearer {token}")
            try:
                with urllib.request.urlopen(request, context=self.context, timeout=20 * PATIENCE) as answer:
                    return answer.status
            except urllib.error.HTTPError as error:
                return error.code

        for path in ("/", "/healthz", "/metrics"):
            self.assertEqual(status(path), 200, path)
        self.assertEqual(status("/metrics", self.tokens["view"]), 200)
        self.assertEqual(status("/metrics", "guess"), 401)

    def test_the_page_is_told_its_role(self):
        page = self.page()
        self.assertEqual(page.next(lambda u: u.HasField("permission")).permission.role, "view")
        self.assertFalse(page.ask(authenticate={"token": "guess"}).ok)
        page._send(
            self.messages.ViewerRequest(authenticate={"token": self.tokens["inject"]}).SerializeToString()
        )
        permission = page.next(lambda u: u.HasField("permission")).permission
        self.assertEqual((permission.role, permission.name), ("inject", "token inject"))


class Files(unittest.TestCase):
    """The daemon reports faulty access files when it starts."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="aprsim-access-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.authority = Authority(folder.name)
        cls.good = cls.authority.certify("server", f"IP:{HOST}")
        cls.other = cls.authority.certify("other")
        cls.late = cls.authority.certify("late", days=-1)
        cls.secret = str(cls.folder / "secret.key")
        subprocess.run(
            ["openssl", "ec", "-aes256", "-passout", "pass:secret", "-in", cls.good.key, "-out", cls.secret],
            capture_output=True, check=True,
        )
        cls.text = cls.folder / "text"
        cls.text.write_text("no PEM\n", encoding="utf-8")
        cls.text.chmod(0o600)
        cls.open_key = cls.folder / "open.key"
        cls.open_key.write_bytes(pathlib.Path(cls.good.key).read_bytes())
        cls.open_key.chmod(0o644)

    def check(self, **keys):
        arguments = [f"{key.replace('__', '.')}={value}" for key, value in keys.items()]
        return subprocess.run(
            [find_binary("aprsimd"), "--check", *(a for s in arguments for a in ("--set", s))],
            capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=60 * PATIENCE, check=False,
        )

    def test_each_mistake_is_named(self):
        good, key = self.good.certificate, self.good.key
        for keys, words in (
            ({"tls__certificate": good}, "both certificate and key"),
            ({"tls__certificate": "/nonexistent", "tls__key": key}, "tls.certificate: cannot read /nonexistent: No such"),
            ({"tls__certificate": self.text, "tls__key": key}, "holds no certificate in PEM"),
            ({"tls__certificate": self.late.certificate, "tls__key": self.late.key}, "has expired"),
            ({"tls__certificate": good, "tls__key": self.other.key}, "is not the key of the certificate in"),
            ({"tls__certificate": good, "tls__key": self.text}, "holds no private key in PEM"),
            ({"tls__certificate": good, "tls__key": self.secret}, "without a password"),
            ({"tls__certificate": good, "tls__key": self.open_key}, "has mode 644"),
            ({"tls__certificate": good, "tls__key": key, "tls__client_ca": self.text}, "tls.client_ca: "),
            ({"tls__certificate": good, "tls__key": key, "tls__client_certificates": "required"}, "client_ca together with"),
            ({"access__file": "/nonexistent"}, "access.file: cannot read /nonexistent"),
            ({"access__file": self.open_key}, "expected 600"),
            ({"access__anonymous": "none", "access__insecure_control": "true"}, "anonymous: view"),
        ):
            done = self.check(**keys)
            self.assertNotEqual(done.returncode, 0, keys)
            self.assertIn(words, done.stderr)
        done = self.check(tls__certificate=good, tls__key=key, tls__client_ca=self.authority.certificate)
        self.assertEqual(done.returncode, 0, done.stderr)


class Audit(WithTokens):
    def test_every_command_stands_with_who_sent_it(self):
        with self.cell("operate") as cell:
            cell.step(3)
            with self.assertRaises(Refused):
                cell.reset()
            cell.snapshot()
            cell.robot("fanuc").take()
        page = PageSocket(page_messages(), self.ports["web"], self.context, 20 * PATIENCE)
        page.ask(authenticate={"token": self.tokens["inject"]})
        page.ask(conveyor={"run": False})
        page.close()
        with socket.create_connection((HOST, self.ports["modbus"])) as modbus:
            modbus.sendall(bytes([0, 1, 0, 0, 0, 6, 1, 6, 0x80, 2, 0, 5]))
            self.assertTrue(modbus.recv(100))

        def lines():
            return [json.loads(line) for line in self.audit_file.read_text(encoding="utf-8").splitlines()]

        eventually(lambda: any(line["wire"] == "modbus" for line in lines()), "the last is written")
        all_lines = lines()

        def found(**wanted):
            return [line for line in all_lines if all(line.get(k) == v for k, v in wanted.items())]

        step = found(wire="grpc", command="aprsim.v1.ControlService/Step", identity="token operate", outcome="ok")
        self.assertIn('"steps":"3"', step[0]["request"])
        self.assertTrue(step[0]["peer"].startswith(f"{HOST}:"))
        reset = found(command="aprsim.v1.ControlService/Reset", identity="token operate")
        self.assertEqual(len(reset), 1)
        self.assertIn("needs the role admin", reset[0]["outcome"])
        self.assertEqual(len(found(wire="web", command="conveyor", identity="token inject", outcome="ok")), 1)
        self.assertTrue(found(wire="crcl.fanuc", command="InitCanonType"))
        self.assertEqual(found(wire="modbus")[0]["request"], "000100000006010680020005")
        for word in ("GetSnapshot", "GetStatusType", "authenticate"):
            self.assertFalse([line for line in all_lines if word in line["command"]], word)
        text = self.audit_file.read_text(encoding="utf-8")
        for token in self.tokens.values():
            self.assertNotIn(token, text)
        self.assertEqual(self.audit_file.stat().st_mode & 0o777, 0o600)


class Elsewhere(unittest.TestCase):
    """Permissions of callers outside the loopback, tested over another address of this machine."""

    @classmethod
    def setUpClass(cls):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.connect(("192.0.2.1", 9))  # sends nothing
                cls.address = probe.getsockname()[0]
            except OSError:
                cls.address = cls._add_address()
        if cls.address is None or cls.address.startswith("127."):
            raise unittest.SkipTest("this machine has no address but the loopback's")

    @classmethod
    def _add_address(cls):
        address = "198.51.100.7"  # for documentation: nobody's
        done = subprocess.run(["ip", "addr", "add", f"{address}/32", "dev", "lo"], capture_output=True, check=False)
        return address if done.returncode in (0, 2) else None

    def start(self, *arguments):
        listeners = [f"{wire}.address=0.0.0.0" for wire in ("crcl", "modbus", "vision", "cameras", "grpc", "web")]
        daemon = Daemon(
            *(a for key in listeners for a in ("--set", key)), *arguments,
            speed="stepped", start_s=60 * PATIENCE,
        )
        self.addCleanup(daemon.close)
        return daemon

    def served(self, daemon, wire):
        ports = json.loads(daemon.ports_file.read_text(encoding="utf-8"))
        requests = {
            "crcl.fanuc": b"<CRCLCommandInstance><CRCLCommand xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
            b"xsi:type=\"GetStatusType\"><CommandID>1</CommandID></CRCLCommand></CRCLCommandInstance>",
            "modbus": bytes([0, 1, 0, 0, 0, 6, 1, 3, 0x80, 0, 0, 1]),
            "vision.fanuc": b"",
            "camera.fanuc_table": b"GET / HTTP/1.1\r\n\r\n",
        }
        try:
            with socket.create_connection((self.address, ports[wire]), timeout=20 * PATIENCE) as client:
                if requests[wire]:
                    client.sendall(requests[wire])
                return bool(client.recv(100))
        except ConnectionError:
            return False

    def test_without_credentials_there_is_only_looking(self):
        daemon = self.start()
        with Cell.connect(daemon.ports_file, host=self.address) as cell:
            with self.assertRaises(Refused) as refused:
                cell.step()
            self.assertEqual(refused.exception.code, "PERMISSION_DENIED")
            self.assertIn("needs the role operate", str(refused.exception))
        with Cell.connect(daemon.ports_file) as here:
            here.step()
        for wire in ("crcl.fanuc", "modbus", "vision.fanuc", "camera.fanuc_table"):
            self.assertFalse(self.served(daemon, wire), wire)
            eventually(lambda w=wire: f"{w}: refused {self.address}" in daemon.log(), "a line in the log")

    def test_unless_it_is_said(self):
        daemon = self.start(
            "--insecure-control",
            *(a for wire in ("crcl", "modbus", "vision", "cameras") for a in ("--set", f"{wire}.allow=[{self.address}]")),
        )
        with Cell.connect(daemon.ports_file, host=self.address) as cell:
            cell.step()
            cell.resume()
        for wire in ("crcl.fanuc", "modbus", "vision.fanuc", "camera.fanuc_table"):
            self.assertTrue(self.served(daemon, wire), wire)


if __name__ == "__main__":
    unittest.main()
