"""Drives the conveyor's registers with pymodbus: pymodbus_client.py PORT."""

import sys

from pymodbus.client import ModbusTcpClient
from pymodbus.mei_message import ReadDeviceInformationRequest

RUN, DIRECTION, SPEED, UNUSED = 0x8000, 0x8001, 0x8002, 0x8040
ESTOP, RESET, COIL = 0x8002, 0x8003, 0x8020


def expect(what, got, wanted):
    if got != wanted:
        sys.exit(f"{what}: got {got!r}, expected {wanted!r}")


def registers(reply):
    if reply.isError():
        sys.exit(f"unexpected error {reply}")
    return reply.registers


def main():
    client = ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]))
    if not client.connect():
        sys.exit("cannot connect")
    other = ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]))
    if not other.connect():
        sys.exit("cannot connect a second time")

    for unit in (0, 1, 255):
        client.write_register(DIRECTION, 1, slave=unit)
        client.write_register(SPEED, 30000, slave=unit)
        client.write_register(RUN, 1, slave=unit)
        expect("start", registers(client.read_holding_registers(RUN, 3, slave=unit)), [1, 1, 30000])
        client.write_registers(RUN, [0, 0, 0], slave=unit)
        expect("stop", registers(other.read_holding_registers(RUN, 3, slave=unit)), [0, 0, 0])

    words = list(range(123))
    client.write_registers(UNUSED, words, slave=1)
    expect("memory", registers(client.read_holding_registers(UNUSED, 123, slave=1)), words)
    expect("inputs", len(registers(client.read_input_registers(0x8000, 125, slave=1))), 125)

    client.write_coils(COIL, [True, False, True], slave=1)
    expect("coils", client.read_coils(COIL, 3, slave=1).bits[:3], [True, False, True])
    expect("ready", client.read_discrete_inputs(RUN, 256, slave=1).bits, [True] + 255 * [False])
    client.write_coil(ESTOP, True, slave=1)
    client.write_coil(RUN, True, slave=1)
    expect("held", client.read_coils(RUN, 4, slave=1).bits[:4], [False, False, True, False])
    inputs = client.read_discrete_inputs(RUN, 5, slave=1).bits[:5]
    expect("stopped", inputs, [False, False, False, True, True])
    client.write_coil(ESTOP, False, slave=1)
    client.write_coil(RESET, True, slave=1)
    expect("reset", client.read_discrete_inputs(RUN, 5, slave=1).bits[0], True)

    client.write_register(UNUSED, 0x12, slave=1)
    client.mask_write_register(UNUSED, 0xF2, 0x25, unit=1)
    both = client.readwrite_registers(
        read_address=UNUSED, read_count=2, write_address=UNUSED + 1, write_registers=[9], unit=1
    )
    expect("read and write", registers(both), [0x17, 9])

    identity = client.execute(ReadDeviceInformationRequest(read_code=2, unit=1)).information
    expect("vendor", identity[0], b"aprsim")
    expect("product", identity[1], b"APRSIM-CONVEYOR")

    expect("bad value", client.write_register(RUN, 2, slave=1).exception_code, 3)
    expect("bad address", client.read_holding_registers(0, 1, slave=1).exception_code, 2)
    expect("bad range", client.read_holding_registers(0x80FF, 2, slave=1).exception_code, 2)
    print("all as expected")


if __name__ == "__main__":
    main()
