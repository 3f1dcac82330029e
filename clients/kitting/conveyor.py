"""The belt, over Modbus/TCP: the three registers that the laboratory's controllers write, and the
encoder's reading where the PLC has one."""

from __future__ import annotations

import socket
import struct
import threading
import time
from typing import Callable

from cell import Belt

RUN, DIRECTION, SPEED = 0x8000, 0x8001, 0x8002  # holding registers
ENCODER = 0x8004  # input registers: 32 bit, high word first
ENCODER_MM = 0.01  # a count
_POLL_S = 0.005  # of the encoder, while the belt runs
_EXCEPTIONS = {
    1: "illegal function",
    2: "illegal address",
    3: "illegal value",
    4: "device failure",
    6: "busy",
}


class ConveyorError(Exception):
    """The PLC refuses, is silent, or the belt does not move."""


class Modbus:
    """A client that waits for each answer."""

    def __init__(self, host: str, port: int, timeout_s: float = 3.0) -> None:
        self.requests = 0
        self._transaction = 0
        try:
            self._socket = socket.create_connection((host, port), timeout_s)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError as error:
            raise ConveyorError(f"no connection to {host}:{port}: {error}") from error

    def close(self) -> None:
        self._socket.close()

    def write_register(self, address: int, value: int) -> None:
        answer = self._ask(struct.pack(">BHH", 6, address, value))
        if answer != struct.pack(">BHH", 6, address, value):
            raise ConveyorError(
                f"register {address:#06x}: the answer is not an echo of the request"
            )

    def read_input_registers(self, address: int, count: int) -> tuple[int, ...]:
        answer = self._ask(struct.pack(">BHH", 4, address, count))
        if len(answer) != 2 + 2 * count or answer[1] != 2 * count:
            raise ConveyorError(f"registers {address:#06x}: {len(answer)} bytes in the answer")
        return struct.unpack(f">{count}H", answer[2:])

    def _ask(self, request: bytes) -> bytes:
        self._transaction = (self._transaction + 1) & 0xFFFF
        self.requests += 1
        try:
            self._socket.sendall(
                struct.pack(">HHHB", self._transaction, 0, len(request) + 1, 1) + request
            )
            while True:
                transaction, protocol, length, _ = struct.unpack(">HHHB", self._take(7))
                if protocol != 0 or not 2 <= length <= 254:
                    raise ConveyorError("the answer is not Modbus/TCP")
                answer = self._take(length - 1)
                # What comes late belongs to a request that has been given up.
                if transaction == self._transaction:
                    break
        except OSError as error:
            raise ConveyorError(str(error)) from error
        if answer[0] == request[0] | 0x80:
            code = answer[1] if len(answer) > 1 else 0
            raise ConveyorError(f"exception {code} ({_EXCEPTIONS.get(code, 'unknown')})")
        if answer[0] != request[0]:
            raise ConveyorError(f"function {answer[0]} in the answer to {request[0]}")
        return answer

    def _take(self, size: int) -> bytes:
        data = b""
        while len(data) < size:
            more = self._socket.recv(size - len(data))
            if not more:
                raise ConveyorError("the PLC has closed the connection")
            data += more
        return data


class Conveyor:
    """Steps of the belt. The caller holds the space over the belt meanwhile. `now` and `sleep` are the
    caller's clock."""

    def __init__(self, belt: Belt) -> None:
        self.belt = belt
        self.requests = 0

    def step(
        self,
        way_mm: float,
        interrupted: threading.Event,
        now: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> float:
        """Runs the belt by about `way_mm`, negative for backward, and tells how far it went by its
        encoder. Whatever happens the belt is told to stop."""
        modbus = Modbus(self.belt.host, self.belt.port)
        try:
            start = self._position(modbus)
            modbus.write_register(DIRECTION, 1 if way_mm > 0 else 0)
            modbus.write_register(SPEED, round(self.belt.speed_mm_s / self.belt.mm_s_per_count))
            try:
                modbus.write_register(RUN, 1)
                self._wait_for_way(modbus, start, abs(way_mm), interrupted, now, sleep)
            finally:
                modbus.write_register(RUN, 0)
                modbus.write_register(SPEED, 0)
            return self._rest(modbus, now, sleep) - start
        finally:
            self.requests += modbus.requests
            modbus.close()

    def stop(self) -> float:
        """Stops the belt, waits until it stands, and tells where that is by its encoder [mm]."""
        modbus = Modbus(self.belt.host, self.belt.port)
        try:
            modbus.write_register(RUN, 0)
            return self._rest(modbus, time.monotonic, time.sleep)
        finally:
            self.requests += modbus.requests
            modbus.close()

    @staticmethod
    def _position(modbus: Modbus) -> float:
        high, low = modbus.read_input_registers(ENCODER, 2)
        (counts,) = struct.unpack(">i", struct.pack(">HH", high, low))
        return float(counts) * ENCODER_MM

    def _wait_for_way(
        self,
        modbus: Modbus,
        start: float,
        way_mm: float,
        interrupted: threading.Event,
        now: Callable[[], float],
        sleep: Callable[[float], None],
    ) -> None:
        last, moved_at = start, now()
        while not interrupted.is_set():
            here = self._position(modbus)
            if abs(here - start) >= way_mm:
                return
            if here != last:
                last, moved_at = here, now()
            elif now() - moved_at > 3:
                raise ConveyorError(
                    f"the belt has been told to run and stands still after {abs(here - start):.0f} mm"
                )
            sleep(_POLL_S)

    @staticmethod
    def _rest(
        modbus: Modbus, now: Callable[[], float], sleep: Callable[[float], None]
    ) -> float:
        """Where the belt has come to rest."""
        deadline = now() + 10
        last, since = Conveyor._position(modbus), now()
        while now() < deadline:
            sleep(0.05)
            here = Conveyor._position(modbus)
            if here != last:
                last, since = here, now()
            elif now() - since > 0.25:
                return here
        raise ConveyorError("the belt does not stop")
