"""The attacks: each takes a daemon and a number of seconds, and does its worst for so long."""

import random
import re
import resource
import socket
import struct
import threading
import time

from cell import Crcl, Http2, document, pose

ATTACKS = {}


def attack(function=None, **options):
    """Registers an attack; `options` are its daemon's (cell.Daemon), `arguments` its command line."""
    if function is None:
        return lambda later: attack(later, **options)
    function.options = options
    ATTACKS[function.__name__.replace("_", " ")] = function
    return function


def until(seconds):
    return time.monotonic() + seconds


def reader(connection, stop):
    """Reads and forgets what comes."""
    connection.settimeout(0.5)
    while not stop.is_set():
        try:
            if not connection.recv(1 << 16):
                return
        except socket.timeout:
            continue
        except OSError:
            return


def send_to_all(connections, data):
    """The limits of simultaneous connections."""
    for connection in connections:
        try:
            connection.send(data)
        except OSError:
            pass


def close_all(connections):
    for connection in connections:
        connection.close()


def at_once(run, clients, seconds, stop):
    """Calls run() in so many threads until `stop` is set, which is after so many seconds."""
    threads = [threading.Thread(target=run, daemon=True) for _ in range(clients)]
    for thread in threads:
        thread.start()
    time.sleep(seconds)
    stop.set()
    for thread in threads:
        thread.join(10)


def flood(daemon, seconds, clients, make, pause=0):
    """So many clients that send documents as fast as they are taken, or every `pause` seconds;
    `make(number)` makes one."""
    stop = threading.Event()

    def run():
        try:
            client = Crcl(daemon.ports["crcl.fanuc"], 5)
            threading.Thread(target=reader, args=(client.socket, stop), daemon=True).start()
            client.socket.settimeout(5)
            client.socket.sendall(document("InitCanon", 1))
            number = 1
            while not stop.is_set():
                number += 1
                client.socket.sendall(make(number))
                time.sleep(pause)
        except OSError:
            pass

    at_once(run, clients, seconds, stop)


def move_to(number, straight=False):
    end = pose("EndPosition", 450 + 20 * (number % 3), -60 + 10 * (number % 7), 250)
    return document("MoveTo", number, f"<MoveStraight>{str(straight).lower()}</MoveStraight>{end}")


def program_of(*commands):
    """Commands without their documents, as a CRCLProgram."""
    return (
        b'<?xml version="1.0" encoding="UTF-8"?>'
        b'<CRCLProgram xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">'
        + b"".join(
            b"<"
            + tag
            + b" "
            + re.search(rb"<CRCLCommand (.*)</CRCLCommand>", text, re.S).group(1)
            + b"</"
            + tag
            + b">"
            for tag, text in zip(
                [b"InitCanon"] + [b"MiddleCommand"] * (len(commands) - 2) + [b"EndCanon"], commands
            )
        )
        + b"</CRCLProgram>"
    )


def move_through(number, waypoints):
    """A zigzag, as one command; documents of more than 64 KB are refused."""
    points = "".join(
        pose("Waypoint", round(450 + 0.04 * i, 2), (i * 37) % 100 * 0.6 // 1, 250)
        for i in range(waypoints)
    )
    return document(
        "MoveThroughTo",
        number,
        f"<MoveStraight>true</MoveStraight>{points}<NumPositions>{waypoints}</NumPositions>",
    )


@attack
def nothing(_daemon, seconds):
    """No attack, for comparison."""
    time.sleep(seconds)


@attack
def MoveTo_by_1_client(daemon, seconds):
    flood(daemon, seconds, 1, move_to)


@attack
def MoveTo_by_50_clients(daemon, seconds):
    flood(daemon, seconds, 50, move_to)


@attack
def straight_MoveTo_by_8_clients(daemon, seconds):
    flood(daemon, seconds, 8, lambda number: move_to(number, True))


@attack
def MoveThroughTo_of_1000(daemon, seconds):
    """Programs of one long move, each given up for the next."""
    text = program_of(document("InitCanon", 1), move_through(2, 1000), document("EndCanon", 3))
    flood(daemon, seconds, 1, lambda _number: text, pause=0.1)


@attack
def MoveThroughTo_of_230(daemon, seconds):
    text = move_through(7, 230)
    flood(daemon, seconds, 4, lambda _number: text)


@attack
def long_plans_and_short_ones(daemon, seconds):
    long = move_through(7, 230)
    flood(daemon, seconds, 2, lambda number: long if number % 5 == 0 else move_to(number))


@attack
def GetStatus_by_50_clients(daemon, seconds):
    flood(daemon, seconds, 50, lambda number: document("GetStatus", number))


@attack
def statuses_that_nobody_reads(daemon, seconds):
    end = until(seconds)
    connections = []
    for _ in range(20):
        connection = socket.create_connection(("127.0.0.1", daemon.ports["crcl.fanuc"]), 5)
        connection.setblocking(False)
        connections.append(connection)
    ask = document("GetStatus", 1) * 50
    while time.monotonic() < end:
        send_to_all(connections, ask)
        time.sleep(0.001)
    close_all(connections)


@attack
def connect_storm(daemon, seconds):
    """Connections that come and end with RST, on every port."""
    end = until(seconds)
    ports = list(daemon.ports.values())
    while time.monotonic() < end:
        for port in ports:
            try:
                connection = socket.create_connection(("127.0.0.1", port), 1)
                connection.setsockopt(
                    socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0)
                )
                connection.close()
            except OSError:
                pass


@attack
def idle_connections_1000(daemon, seconds):
    connections = []
    for port in daemon.ports.values():
        for _ in range(150):
            try:
                connections.append(socket.create_connection(("127.0.0.1", port), 1))
            except OSError:
                break
    time.sleep(seconds)
    close_all(connections)


NEWCOMERS = ["crcl.fanuc", "crcl.motoman", "modbus", "camera.fanuc_table", "grpc", "web"]
ASKED = {
    "crcl": document("GetStatus", 1),
    "modbus": struct.pack(">HHHBBHH", 1, 0, 6, 1, 3, 0x8000, 1),
    "vision": b"",
    "camera": b"GET / HTTP/1.1\r\n\r\n",
    "grpc": b"",
    "web": b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
}


def is_served(daemon, name, address):
    """Whether a new client gets an answer."""
    try:
        with socket.create_connection(("127.0.0.1", daemon.ports[name]), 5, (address, 0)) as client:
            client.sendall(ASKED[name.split(".")[0]])
            return bool(client.recv(1 << 16))
    except OSError:
        return False


def expect_service(daemon, name, address="127.0.0.1"):
    """Checks that a new client is served, at the latest once the one before it is forgotten."""
    end = until(5)
    while not is_served(daemon, name, address):
        if time.monotonic() > end:
            raise RuntimeError(f"{name} does not serve a new client from {address}")


def besiege(daemon, seconds, names, address, taken, hold):
    """Keeps so many connections open to each of these listeners, on each of which `hold` does its
    worst every 50 ms, while new clients connect."""
    end = until(seconds)
    held = {name: [] for name in names}
    try:
        while time.monotonic() < end:
            for name in names:
                while len(held[name]) < taken:
                    try:
                        connection = socket.create_connection(
                            ("127.0.0.1", daemon.ports[name]), 5
                        )
                        connection.setblocking(False)
                        held[name].append(connection)
                    except OSError:
                        break
                held[name] = [one for one in held[name] if hold(one, name)]
                expect_service(daemon, name, address)
            time.sleep(0.05)
    finally:
        for connections in held.values():
            close_all(connections)


def says_nothing(connection, _name):
    try:
        return bool(connection.recv(1 << 16))
    except BlockingIOError:
        return True
    except OSError:
        return False


def drips(connection, name):
    """Never a whole document."""
    try:
        connection.send(ASKED[name.split(".")[0]][:3] or b"P")
    except OSError:
        return False
    return says_nothing(connection, name)


def asks(connection, name):
    """Repeats requests that need no role."""
    try:
        connection.send(ASKED[name.split(".")[0]])
    except OSError:
        return False
    return says_nothing(connection, name)


@attack
def places_taken_by_the_idle(daemon, seconds):
    """From the address of the new clients."""
    besiege(daemon, seconds, NEWCOMERS, "127.0.0.1", 140, says_nothing)


@attack
def places_taken_by_those_who_never_finish(daemon, seconds):
    besiege(daemon, seconds, NEWCOMERS, "127.0.0.1", 140, drips)


@attack
def places_taken_by_the_busy(daemon, seconds):
    """From one address; the new clients come from another."""
    names = [*NEWCOMERS, "vision.fanuc", "vision.motoman"]
    besiege(daemon, seconds, names, "127.0.0.2", 140, asks)


@attack
def no_descriptors(daemon, seconds):
    """None left while clients come; then all are served again."""
    before = resource.prlimit(daemon.process.pid, resource.RLIMIT_NOFILE)
    resource.prlimit(daemon.process.pid, resource.RLIMIT_NOFILE, (3, before[1]))
    end = until(seconds)
    waiting = []
    try:
        while time.monotonic() < end:
            for port in daemon.ports.values():
                try:
                    waiting.append(socket.create_connection(("127.0.0.1", port), 0.2))
                except OSError:
                    pass
            time.sleep(0.05)
            if len(waiting) > 200:
                close_all(waiting)
                waiting = []
    finally:
        resource.prlimit(daemon.process.pid, resource.RLIMIT_NOFILE, before)
        close_all(waiting)
    for name in daemon.ports:
        expect_service(daemon, name)


@attack
def garbage(daemon, seconds):
    end = until(seconds)
    noise = random.Random(5)
    ports = list(daemon.ports.values())
    while time.monotonic() < end:
        try:
            connection = socket.create_connection(("127.0.0.1", noise.choice(ports)), 1)
            connection.sendall(noise.randbytes(noise.randrange(1, 20000)))
            connection.close()
        except OSError:
            pass


@attack
def documents_that_never_end(daemon, seconds):
    """A byte at a time, on 30 connections."""
    end = until(seconds)
    text = document("MoveTo", 1, " " * 4000)
    connections = [
        socket.create_connection(("127.0.0.1", daemon.ports["crcl.fanuc"]), 5) for _ in range(30)
    ]
    at = 0
    while time.monotonic() < end:
        send_to_all(connections, text[at : at + 1])
        at = min(at + 1, len(text) - 60)
        time.sleep(0.002)
    close_all(connections)


@attack
def bombs(daemon, seconds):
    """Entities that multiply, deep nesting, huge attributes, NaN."""
    end = until(seconds)
    entities = b'<!DOCTYPE x [<!ENTITY a "ha">' + b"".join(
        b'<!ENTITY a%d "%s">' % (i, b"&a%s;" % (b"" if i == 0 else b"%d" % (i - 1)) * 10)
        for i in range(10)
    )
    texts = [
        b'<?xml version="1.0"?>' + entities + b"]><CRCLCommandInstance>&a9;</CRCLCommandInstance>",
        b"<CRCLCommandInstance>" + b"<a>" * 5000 + b"</CRCLCommandInstance>",
        b'<CRCLCommandInstance a="' + b"x" * 200000 + b'"></CRCLCommandInstance>',
        move_to(1).replace(b"450", b"NaN").replace(b"470", b"INF"),
    ]
    while time.monotonic() < end:
        for text in texts:
            try:
                connection = socket.create_connection(
                    ("127.0.0.1", daemon.ports["crcl.fanuc"]), 2
                )
                connection.sendall(text)
                connection.close()
            except OSError:
                pass


@attack
def Modbus_flood(daemon, seconds):
    end = until(seconds)
    request = struct.pack(">HHHBBHH", 1, 0, 6, 1, 6, 0x8002, 1000) * 50
    connections = []
    for _ in range(10):
        connection = socket.create_connection(("127.0.0.1", daemon.ports["modbus"]), 5)
        connection.setblocking(False)
        connections.append(connection)
    while time.monotonic() < end:
        for connection in connections:
            try:
                connection.send(request)
                connection.recv(1 << 16)
            except OSError:
                pass
    close_all(connections)


@attack
def settings_while_moving(daemon, seconds):
    """Overrides that change what has been planned."""

    def make(number):
        if number % 3:
            return move_to(number)
        value = 30 + number % 60
        return document(
            "SetRobotParameters",
            number,
            "<ParameterSetting><ParameterName>speed_override</ParameterName>"
            f"<ParameterValue>{value}</ParameterValue></ParameterSetting>",
        )

    flood(daemon, seconds, 4, make)



@attack
def blanks_after_an_end_tag(daemon, seconds):
    """An end tag that goes on with blanks, a few at a time, on 8 connections."""
    end = until(seconds)
    connections = [
        socket.create_connection(("127.0.0.1", daemon.ports["crcl.fanuc"]), 5) for _ in range(8)
    ]
    for connection in connections:
        connection.sendall(b"<CRCLCommandInstance></CRCLCommandInstance")
    while time.monotonic() < end:
        send_to_all(connections, b" ")
        time.sleep(0.0003)
    close_all(connections)


@attack
def a_web_page(daemon, seconds):
    """Requests that a web page can make a browser send to any port."""
    end = until(seconds)
    body = document("StopMotion", 1, "<StopCondition>Fast</StopCondition>")
    request = b"POST / HTTP/1.1\r\nContent-Length: %d\r\n\r\n" % len(body) + body
    while time.monotonic() < end:
        for port in daemon.ports.values():
            try:
                connection = socket.create_connection(("127.0.0.1", port), 1)
                connection.sendall(request)
                connection.close()
            except OSError:
                pass


@attack
def messages_without_end(daemon, seconds):
    """A program of one loop of long messages, and forged lines for the log."""
    text = b"x" * 20000 + b"&#10;[2026-01-01] [error] forged"
    program = (
        b'<?xml version="1.0"?><CRCLProgram xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">'
        b"<InitCanon><CommandID>1</CommandID></InitCanon>"
        b'<MiddleCommand xsi:type="LoopBlockStartType"><CommandID>2</CommandID>'
        b"<RepeatCount>999000</RepeatCount></MiddleCommand>"
        b'<MiddleCommand xsi:type="MessageType"><CommandID>3</CommandID><Message>'
        + text
        + b"</Message></MiddleCommand>"
        b'<MiddleCommand xsi:type="LoopBlockEndType"><CommandID>4</CommandID></MiddleCommand>'
        b"<EndCanon><CommandID>5</CommandID></EndCanon></CRCLProgram>"
    )
    client = Crcl(daemon.ports["crcl.fanuc"])
    client.socket.sendall(program)
    time.sleep(seconds)
    client.close()
    if len(daemon.log_text()) > 200_000:
        raise RuntimeError(f"a log of {len(daemon.log_text())} bytes")


@attack
def new_namespaces(daemon, seconds):
    def make(number):
        prefixes = " ".join(
            f'xmlns:p{number}x{i}="http://example.org/{number}/{i}"' for i in range(100)
        )
        return document("GetStatus", number).replace(b"<CRCLCommandInstance", b"<CRCLCommandInstance " + prefixes.encode(), 1)

    flood(daemon, seconds, 4, make)


def http2_flood(daemon, seconds, connections, make):
    """Connections that each send what `make` gives them, again and again, and come back when they
    are closed; an honest client beside them makes a call now and then."""
    end = until(seconds)

    def run():
        while time.monotonic() < end:
            try:
                client = Http2(daemon.ports["grpc"])
                while time.monotonic() < end and client.read_some():
                    client.socket.sendall(make(client))
                client.close()
            except OSError:
                time.sleep(0.001)

    threads = [threading.Thread(target=run, daemon=True) for _ in range(connections)]
    for thread in threads:
        thread.start()
    while time.monotonic() < end:
        code, text = daemon.status()
        # 1 is an answer too: the cell is slower than it should be, as on a busy machine.
        if code not in (0, 1):
            raise RuntimeError("an honest client met: " + text)
        time.sleep(0.05)
    for thread in threads:
        thread.join(10)


def opened_and_reset(client):
    return b"".join(client.open_call() + client.reset() for _ in range(500))


@attack
def HTTP2_rapid_reset(daemon, seconds):
    http2_flood(daemon, seconds, 1, opened_and_reset)


@attack
def HTTP2_rapid_reset_on_16_connections(daemon, seconds):
    http2_flood(daemon, seconds, 16, opened_and_reset)


@attack
def HTTP2_rapid_reset_just_below_the_limit(daemon, seconds):
    """Each connection leaves before it is closed."""

    def make(client):
        if client.stream > 0:
            raise OSError("next connection")
        return b"".join(client.open_call() + client.reset() for _ in range(190))

    http2_flood(daemon, seconds, 4, make)


@attack
def HTTP2_streams_without_end(daemon, seconds):
    http2_flood(
        daemon, seconds, 4, lambda client: b"".join(client.open_call() for _ in range(100))
    )


@attack
def HTTP2_settings_and_pings(daemon, seconds):
    frames = (
        Http2.frame(Http2.SETTINGS, 0, 0) + Http2.frame(Http2.PING, 0, 0, b"12345678")
    ) * 500
    http2_flood(daemon, seconds, 4, lambda _client: frames)


@attack
def HTTP2_continuations(daemon, seconds):
    """A header block that never ends."""

    def make(client):
        head = b"" if client.stream > 0 else client.open_call()[:9]
        if head:
            client.stream = 1
            return Http2.frame(Http2.HEADERS, 0, 1, b"\x82")
        return Http2.frame(Http2.CONTINUATION, 0, 1, b"\x82" * 1000) * 20

    http2_flood(daemon, seconds, 4, make)


@attack
def HTTP2_calls_of_headers_alone(daemon, seconds):
    """Almost all connections that are allowed, each with all its calls open, as much metadata as is
    taken, and no message; gRPC's share of the memory holds them."""
    metadata = [(b"x-%d" % number, b"a" * 120) for number in range(45)]  # counts 7.3 of 8 kB
    http2_flood(
        daemon,
        seconds,
        60,
        lambda client: b"" if client.stream > 0 else b"".join(
            client.open_call(metadata=metadata) for _ in range(32)
        ),
    )


@attack
def request_smuggling(daemon, seconds):
    """Requests that hide another one from whoever counts their bytes differently."""
    end = until(seconds)
    port = daemon.ports["web"]
    hidden = b"GET /hidden HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    heads = [
        b"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n",
        b"Transfer-Encoding: chunked\r\nContent-Length: 5\r\n",
        b"Content-Length: 5\r\nContent-Length: 60\r\n",
        b"Transfer-Encoding: chunked, identity\r\n",
        b"Transfer-Encoding : chunked\r\n",
        b"Transfer-Encoding: xchunked\r\n",
        b"Content-Length: +5\r\n",
        b"Content-Length: 5 60\r\n",
        b"Content-Length: 99999999999999999999\r\n",
        b"Content-Length: -1\r\n",
        b" folded: line\r\n",
        b"Host: elsewhere\r\n",
    ]
    while time.monotonic() < end:
        for head in heads:
            for method in (b"GET", b"POST"):
                connection = socket.create_connection(("127.0.0.1", port), 2)
                try:
                    connection.sendall(
                        method + b" / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n" % port + head
                        + b"\r\n0\r\n\r\n" + hidden
                    )
                    connection.settimeout(0.2)
                    answer = b""
                    while data := connection.recv(1 << 16):
                        answer += data
                except OSError:
                    pass
                finally:
                    connection.close()
                # The body may be taken for a request only if the head is refused or has no body.
                statuses = re.findall(rb"HTTP/1\.1 (\d+)", answer)
                if head.startswith((b"Content-Length: 5\r\nT", b"Transfer-Encoding: chunked\r\nC")):
                    if len(statuses) > 1:
                        raise RuntimeError(f"{head!r} was answered {statuses}")


def control_flood(daemon, seconds, requests):
    """Calls of ControlService, one after the other as fast as they are answered."""
    end = until(seconds)
    number = 0
    client = Http2(daemon.ports["grpc"])
    while time.monotonic() < end:
        for method, message in requests(number):
            client.socket.sendall(client.call(b"/aprsim.v1.ControlService/" + method, message))
        number += 1
        client.read_some()
        time.sleep(0.005)
    client.close()


def named(name):
    """A message with a name in its first field."""
    return b"\x0a" + bytes([len(name)]) + name


@attack
def saved_states(daemon, seconds):
    """Saves under new names while long paths run."""
    stop = threading.Event()

    def paths():
        client = Crcl(daemon.ports["crcl.fanuc"])
        text = program_of(document("InitCanon", 1), move_through(2, 1000), document("EndCanon", 3))
        while not stop.wait(2):
            client.socket.sendall(text)
        client.close()

    thread = threading.Thread(target=paths, daemon=True)
    thread.start()
    control_flood(daemon, seconds, lambda number: [(b"SaveState", named(b"state %d" % number))])
    stop.set()
    thread.join(10)


@attack
def resets_and_loads(daemon, seconds):
    control_flood(
        daemon,
        seconds,
        lambda number: [
            (b"SaveState", named(b"one")),
            (b"Reset", b"") if number % 2 else (b"LoadState", named(b"one")),
        ],
    )


SIMPLE_MESSAGE = {"arguments": ["--scene", "aprs_2024"]}


def simple_message(kind, body, length=None):
    return struct.pack(">4i", 12 + len(body) if length is None else length, kind, 2, 0) + body


def motoman_point(sequence, seconds, joint=0.0):
    return simple_message(
        14, struct.pack(">3if", 0, sequence, 7, seconds) + struct.pack(">f", joint) + bytes(116), 136
    )


def connect_to(daemon, name):
    connection = socket.create_connection(("127.0.0.1", daemon.ports[name]), 5)
    connection.setblocking(False)
    return connection


def exchange(connection, data):
    """Sends what the kernel takes, forgets what has come; False where the peer has gone."""
    try:
        connection.send(data)
        return connection.recv(1 << 16) != b""
    except (BlockingIOError, InterruptedError):
        return True
    except OSError:
        return False


def flood_port(daemon, seconds, name, data):
    """One client after the other: a robot's controller serves few."""
    end = until(seconds)
    connection = connect_to(daemon, name)
    while time.monotonic() < end:
        if not exchange(connection, data):
            connection.close()
            connection = connect_to(daemon, name)
    connection.close()


@attack(**SIMPLE_MESSAGE)
def Simple_Message_flood_of_points(daemon, seconds):
    """Points that jump, among requests to start."""
    start = simple_message(2001, struct.pack(">3i", 0, 0, 200121) + bytes(40))
    points = b"".join(motoman_point(i, 0.1 * i, 3.0 * (i % 2)) for i in range(50))
    flood_port(daemon, seconds, "motion.motoman", start + points)


@attack(**SIMPLE_MESSAGE)
def Simple_Message_flood_of_moves(daemon, seconds):
    moves = b"".join(
        simple_message(11, struct.pack(">i6f", i, *([0.3 * (i % 2)] * 6)) + bytes(24))
        for i in range(50)
    )
    flood_port(daemon, seconds, "motion.fanuc", moves)


@attack(**SIMPLE_MESSAGE)
def Simple_Message_flood_of_valves(daemon, seconds):
    valves = b"".join(
        simple_message(2005, struct.pack(">2i", address, value), 25)
        for value in (0, 1)
        for address in (10010, 10011, 10012)
    )
    flood_port(daemon, seconds, "gripper.motoman", valves * 20)


@attack(**SIMPLE_MESSAGE)
def Simple_Message_garbage(daemon, seconds):
    """Noise behind a believable beginning, cut anywhere."""
    end = until(seconds)
    noise = random.Random(6)
    names = [name for name in daemon.ports if name.startswith(("motion.", "state.", "gripper."))]
    kinds = [1, 10, 11, 13, 14, 15, 2001, 2002, 2003, 2005, 2012, 2016, 2018, 9999]
    while time.monotonic() < end:
        try:
            connection = socket.create_connection(("127.0.0.1", daemon.ports[noise.choice(names)]), 1)
            for _ in range(noise.randrange(1, 20)):
                body = noise.randbytes(noise.randrange(0, 600))
                length = noise.choice([None, 0, -1, 2**31 - 1])
                connection.sendall(simple_message(noise.choice(kinds), body, length))
            connection.close()
        except OSError:
            pass


@attack(**SIMPLE_MESSAGE)
def states_of_a_robot_that_nobody_reads(daemon, seconds):
    end = until(seconds)
    held = []
    while time.monotonic() < end:
        for name in ("state.fanuc", "state.motoman"):
            try:
                held.append(socket.create_connection(("127.0.0.1", daemon.ports[name]), 1))
            except OSError:
                pass
        time.sleep(0.01)
    close_all(held)


def simple_message_ports(daemon):
    return [name for name in daemon.ports if name.startswith(("motion.", "state.", "gripper."))]


@attack(**SIMPLE_MESSAGE)
def Simple_Message_that_nobody_reads(daemon, seconds):
    """States, and replies to many requests, that nobody reads, on ever new connections."""
    end = until(seconds)
    clients = []
    while time.monotonic() < end:
        for name in simple_message_ports(daemon):
            try:
                clients.append(connect_to(daemon, name))
            except OSError:
                pass
        send_to_all(clients, simple_message(1, b"") * 200)
        close_all(clients[:-60])
        clients = clients[-60:]
        time.sleep(0.02)
    close_all(clients)


@attack(**SIMPLE_MESSAGE)
def Simple_Message_wild_numbers(daemon, seconds):
    """Points, addresses and commands with numbers that no robot has."""
    end = until(seconds)
    noise = random.Random(8)
    numbers = (1e38, -1e30, float("nan"), float("inf"), 0.0, 1e-45)
    whole = lambda: noise.choice((noise.randrange(-(1 << 31), 1 << 31), 0, -1, -4))  # noqa: E731
    while time.monotonic() < end:
        wild = [noise.choice(numbers) for _ in range(30)]
        messages = (
            simple_message(14, struct.pack(">3if30f", 0, whole(), 7, wild[0], *wild)),
            simple_message(11, struct.pack(">i12f", whole(), *wild[:12])),
            simple_message(2001, struct.pack(">3i", whole(), whole(), 200101 + noise.randrange(30)) + bytes(40)),
            simple_message(2005, struct.pack(">2i", whole(), whole())),
            simple_message(2018, struct.pack(">3i", whole(), whole(), whole())),
        )
        try:
            connection = connect_to(daemon, noise.choice(simple_message_ports(daemon)))
            for message in noise.choices(messages, k=40):
                exchange(connection, message)
            connection.close()
        except OSError:
            pass


@attack(**SIMPLE_MESSAGE)
def Simple_Message_connect_storm(daemon, seconds):
    end = until(seconds)
    while time.monotonic() < end:
        for name in simple_message_ports(daemon):
            try:
                connect_to(daemon, name).close()
            except OSError:
                pass


SECURE = {"secure": True}
HOLDING = struct.pack(">HHHBBHH", 1, 0, 6, 1, 3, 0x8000, 3)  # a request that a viewer may make


def expect_secure_service(daemon):
    """That a viewer is served within ten seconds, the limit of handshakes a second included."""
    end = until(10)
    while True:
        try:
            client = daemon.security.connect(
                daemon.ports["modbus_tls"], daemon.security.context(daemon.security.viewer)
            )
            client.sendall(HOLDING)
            answered = len(client.recv(64)) == 15
            client.close()
            if answered:
                return
        except OSError:
            pass
        if time.monotonic() > end:
            raise RuntimeError("modbus_tls does not serve any more")


def storm(daemon, seconds, clients, act):
    """So many threads that do `act(port)` again and again; then the port serves."""
    stop = threading.Event()

    def run():
        while not stop.is_set():
            try:
                act(daemon.ports["modbus_tls"])
            except OSError:
                pass

    at_once(run, clients, seconds, stop)
    expect_secure_service(daemon)


@attack(**SECURE)
def Modbus_Security_handshakes_begun(daemon, seconds):
    """Greetings that cost the server a signature, and whose answer nobody awaits."""
    greeting = daemon.security.greeting()

    def act(port):
        connection = socket.create_connection(("127.0.0.1", port), 1)
        connection.sendall(greeting)
        connection.close()

    storm(daemon, seconds, 8, act)


@attack(**SECURE)
def Modbus_Security_half_open(daemon, seconds):
    """Halves of greetings, then silence, on ever new connections."""
    greeting, end = daemon.security.greeting(), until(seconds)
    held = []
    while time.monotonic() < end:
        try:
            connection = socket.create_connection(("127.0.0.1", daemon.ports["modbus_tls"]), 1)
            connection.sendall(greeting[: random.Random(len(held)).randrange(1, len(greeting))])
            held.append(connection)
        except OSError:
            pass
        close_all(held[:-500])
        held = held[-500:]
        time.sleep(0.001)
    expect_secure_service(daemon)
    close_all(held)


@attack(**SECURE)
def Modbus_Security_garbage(daemon, seconds):
    """Noise, plain Modbus, records that lie about their length, and greetings with flipped bits."""
    noise, greeting = random.Random(9), daemon.security.greeting()

    def flipped():
        data = bytearray(greeting)
        for _ in range(noise.randrange(1, 8)):
            data[noise.randrange(len(data))] ^= 1 << noise.randrange(8)
        return bytes(data)

    def act(port):
        connection = socket.create_connection(("127.0.0.1", port), 1)
        connection.sendall(
            noise.choice(
                (
                    noise.randbytes(noise.randrange(1, 20000)),
                    HOLDING * 20,
                    struct.pack(">BHH", noise.randrange(20, 25), 0x303, noise.randrange(65536))
                    + noise.randbytes(200),
                    flipped(),
                )
            )
        )
        connection.close()

    storm(daemon, seconds, 4, act)


@attack(**SECURE)
def Modbus_Security_without_a_role(daemon, seconds):
    """Clients without a certificate, with one of another authority, and with roles that are none."""
    contexts = [daemon.security.context(one) for one in daemon.security.unserved]
    choice = random.Random(10)

    def act(port):
        client = daemon.security.connect(port, choice.choice(contexts), 1)
        client.sendall(HOLDING)
        if len(client.recv(64)) == 15:
            raise RuntimeError("a client without a role was served")
        client.close()

    storm(daemon, seconds, 4, act)


@attack(**SECURE)
def Modbus_Security_flood_of_writes(daemon, seconds):
    """Writes by a role that has no right to them, and by one that has, in records of many requests."""
    write = struct.pack(">HHHBBHH", 1, 0, 6, 1, 6, 0x8002, 1000) * 50
    security, end = daemon.security, until(seconds)
    clients = []
    for one in [security.viewer, security.operator] * 5:
        clients.append(security.connect(daemon.ports["modbus_tls"], security.context(one)))
        clients[-1].settimeout(0.01)
    while time.monotonic() < end:
        for client in clients:
            try:
                client.send(write)
                client.recv(1 << 16)
            except OSError:
                pass
    close_all(clients)
    expect_secure_service(daemon)


@attack(log_pipe=True, arguments=["--set", "log_level=debug"])
def a_log_that_nobody_reads(daemon, seconds):
    flood(daemon, seconds, 4, lambda number: document("InitCanon", number), pause=0.0005)


@attack(files="least")
def descriptors_run_short(daemon, seconds):
    """As few as the daemon starts with, and connections to every port."""
    connect_storm(daemon, seconds / 2)
    idle_connections_1000(daemon, seconds / 2)


@attack
def memory_runs_short(daemon, seconds):
    """No more address space than 256 MB above what it has, for programs and states that want it."""
    with open(f"/proc/{daemon.process.pid}/statm", encoding="ascii") as file:
        size = int(file.read().split()[0]) * resource.getpagesize()
    limit = size + (256 << 20)
    resource.prlimit(daemon.process.pid, resource.RLIMIT_AS, (limit, limit))
    saved_states(daemon, seconds)
