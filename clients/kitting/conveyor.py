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
EYES = 0x8008  # discrete inputs: photo-eye 1 and the next ones
_POLL_S = 0.005  # of the encoder, while the belt runs
_EXCEPTIONS = {
    1: "illegal function",
    2: "illegal address",
    3: "illegal value",
    4: "device failure",
    6: "busy",
}


class ConveyorError(Exception):
    """The PLC refuses or does not answer, or the belt does not move."""


class Modbus:
    """A client that waits for each answer."""

    def __init__(self, host: str, port: int, timeout_s: float = 3.0) -> None:
        self.requests = 0
        self.strays = 0  # discarded replies to other requests
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

    def read_discrete_input(self, address: int) -> bool:
        answer = self._ask(struct.pack(">BHH", 2, address, 1))
        if len(answer) != 3 or answer[1] != 1:
            raise ConveyorError(f"input {address:#06x}: {len(answer)} bytes in the answer")
        return bool(answer[2] & 1)

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
                # A late answer belongs to an abandoned request.
                if self.is_answer(transaction):
                    break
                self.strays += 1
        except OSError as error:
            raise ConveyorError(str(error)) from error
        if answer[0] == request[0] | 0x80:
            code = answer[1] if len(answer) > 1 else 0
            raise ConveyorError(f"exception {code} ({_EXCEPTIONS.get(code, 'unknown')})")
        if answer[0] != request[0]:
            raise ConveyorError(f"function {answer[0]} in the answer to {request[0]}")
        return answer

    def is_answer(self, transaction: int) -> bool:
        """Whether a reply belongs to the latest request."""
        return transaction == self._transaction

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
    caller's clock. `by`: end condition of a step: the encoder, the expected time, or a tray in the
    photo-eye of the cell file."""

    connect: type[Modbus] = Modbus
    standstill_s = 3.0  # limit for a running belt
    wrong_way_mm = 5.0

    def __init__(self, belt: Belt, by: str = "encoder") -> None:
        self.belt, self.by = belt, by
        self.requests = 0
        self.strays = 0  # unrequested replies
        self.speed_share: float | None = None  # measured over commanded speed of the latest step
        self.saw_tray = False  # the photo-eye has ended the latest step

    def step(
        self,
        way_mm: float,
        interrupted: threading.Event,
        now: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> float:
        """Run the belt by about `way_mm`, negative for backward. Returns its travel by the encoder [mm].
        The belt is stopped also after an error. Raises ConveyorError."""
        modbus = self.connect(self.belt.host, self.belt.port)
        self.speed_share, self.saw_tray = None, False

        def wait_for(way_mm: float, until: Callable[[], bool] = lambda: False) -> bool:
            if self.by == "time":
                sleep(abs(way_mm) / self.belt.speed_mm_s)
                return False
            return self._wait_for_way(modbus, way_mm, until, interrupted, now, sleep)

        try:
            start = self._position(modbus)
            modbus.write_register(DIRECTION, 1 if way_mm > 0 else 0)
            modbus.write_register(SPEED, round(self.belt.speed_mm_s / self.belt.mm_s_per_count))
            try:
                modbus.write_register(RUN, 1)
                if self.by != "eye":
                    wait_for(way_mm)
                elif wait_for(way_mm, lambda: modbus.read_discrete_input(EYES + self.belt.eye - 1)):
                    self.saw_tray = True
                    wait_for(self.belt.eye_to_work_mm)
            finally:
                modbus.write_register(RUN, 0)
                modbus.write_register(SPEED, 0)
            went = self._rest(modbus, now, sleep) - start
            return way_mm if self.by == "time" else went
        finally:
            self.requests += modbus.requests
            self.strays += modbus.strays
            modbus.close()

    def stop(self, waits: bool = True) -> float:
        """Stop the belt and wait until it is at rest. Returns its position by the encoder [mm]."""
        modbus = self.connect(self.belt.host, self.belt.port)
        try:
            modbus.write_register(RUN, 0)
            if not waits:
                return self._position(modbus)
            return self._rest(modbus, time.monotonic, time.sleep)
        finally:
            self.requests += modbus.requests
            self.strays += modbus.strays
            modbus.close()

    @staticmethod
    def _position(modbus: Modbus) -> float:
        high, low = modbus.read_input_registers(ENCODER, 2)
        (counts,) = struct.unpack(">i", struct.pack(">HH", high, low))
        return float(counts) * ENCODER_MM

    def _wait_for_way(
        self,
        modbus: Modbus,
        way_mm: float,
        until: Callable[[], bool],
        interrupted: threading.Event,
        now: Callable[[], float],
        sleep: Callable[[float], None],
    ) -> bool:
        """True when `until` ended it."""
        start, began = self._position(modbus), now()
        last, moved_at = start, began
        while not interrupted.is_set():
            if until():
                return True
            here = self._position(modbus)
            gone = here - start
            if abs(gone) >= abs(way_mm):
                self.speed_share = abs(way_mm) / self.belt.speed_mm_s / max(now() - began, 1e-3)
                return False
            if abs(gone) > self.wrong_way_mm and gone * way_mm < 0:
                raise ConveyorError(f"the belt runs the other way, {gone:.0f} mm already")
            if here != last:
                last, moved_at = here, now()
            elif now() - moved_at > self.standstill_s:
                raise ConveyorError(
                    f"the belt is commanded to run but is at rest after {abs(gone):.0f} mm"
                )
            sleep(_POLL_S)
        return False

    @staticmethod
    def _rest(
        modbus: Modbus, now: Callable[[], float], sleep: Callable[[float], None]
    ) -> float:
        """The position at which the belt is at rest."""
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
