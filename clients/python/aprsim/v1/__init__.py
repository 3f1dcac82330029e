"""The cell's messages and gRPC services. Generated from `proto/aprsim/v1` when the tree is built or the
package is installed."""

from pathlib import Path

if not (Path(__file__).parent / "control_service_pb2.py").exists():
    raise ImportError(
        "the messages of aprsim are not generated yet: build the tree (server/run, or the target "
        "aprsim_python), or pip install clients/python"
    )
