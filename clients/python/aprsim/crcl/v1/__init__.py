"""CRCL as protobuf messages, and `RobotService` for them over gRPC. Generated from `proto/aprsim/crcl/v1`
when the tree is built or the package is installed."""

from pathlib import Path

if not (Path(__file__).parent / "robot_service_pb2.py").exists():
    raise ImportError(
        "the messages of aprsim are not generated yet: build the tree (server/run, or the target "
        "aprsim_python), or pip install clients/python"
    )
