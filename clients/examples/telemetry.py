"""Reads the cell by gRPC: what is in it, then five samples of the robots' tools.

    aprsimd --any-port --ports-file ports.json &
    APRSIM_PORTS_FILE=ports.json PYTHONPATH=clients/python python3 clients/examples/telemetry.py

This is plain gRPC, with the messages that the build generates. The package in clients/python has
`aprsim.Cell` on top of it.
"""

import json
import os
from itertools import islice

import grpc
from aprsim.v1 import telemetry_service_pb2 as messages
from aprsim.v1.telemetry_service_pb2_grpc import TelemetryServiceStub

# aprsimd writes the ports of all its listeners to a file; without one it uses the default ports.
port = 50051
if ports_file := os.environ.get("APRSIM_PORTS_FILE"):
    with open(ports_file, encoding="utf-8") as file:
        port = json.load(file)["grpc"]

with grpc.insecure_channel(f"127.0.0.1:{port}") as channel:
    telemetry = TelemetryServiceStub(channel)

    # The description holds what does not change, the snapshots what does.
    cell = telemetry.GetCell(messages.GetCellRequest(), timeout=10).cell
    print(f"{cell.scene}: {len(cell.robots)} robots, {len(cell.bodies)} bodies")

    # A read mask keeps the samples small: only these fields of the snapshot are sent.
    request = messages.StreamSnapshotsRequest(rate_hz=20)
    request.read_mask.paths.extend(["sim_time", "robots.name", "robots.tool_in_world"])
    samples = telemetry.StreamSnapshots(request)
    for sample in islice(samples, 5):
        snapshot = sample.snapshot
        time_s = snapshot.sim_time.ToTimedelta().total_seconds()
        for robot in snapshot.robots:
            # Positions are in metres, in the world frame.
            tool = robot.tool_in_world.position_m
            print(
                f"{time_s:.3f} s: {robot.name} has its tool at "
                f"({tool.x:.3f}, {tool.y:.3f}, {tool.z:.3f}) m"
            )
    samples.cancel()
