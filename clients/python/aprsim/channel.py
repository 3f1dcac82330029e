"""A channel to the cell: the common part of the blocking and the asyncio cell."""

from __future__ import annotations

import os
from typing import Any

import grpc

from . import calls
from .endpoints import Endpoints
from .errors import AprsimError, Unreachable
from .hosts import is_this_machine, with_port
from .snapshots import Snapshot
from .v1 import (
    camera_service_pb2_grpc,
    control_service_pb2_grpc,
    history_service_pb2_grpc,
    journal_service_pb2_grpc,
    telemetry_service_pb2_grpc,
    trajectory_service_pb2_grpc,
)

_MAX_MESSAGE_BYTES = 64 << 20
_PROXY_VARIABLES = ("grpc_proxy", "https_proxy", "http_proxy")  # those that gRPC reads


class Channel:
    """The channel with its services, the metadata of every call, and the cached state of the cell."""

    def __init__(self, endpoints: Endpoints, channel: Any, address: str) -> None:
        """`channel`: one of grpc or grpc.aio, or an object with its calls. `address` is for errors."""
        self.endpoints = endpoints
        self._address = address
        self._channel = channel
        self._metadata = calls.metadata_of(endpoints)
        self._stubs: dict[calls.Service, Any] = {
            "Camera": camera_service_pb2_grpc.CameraServiceStub(self._channel),
            "Control": control_service_pb2_grpc.ControlServiceStub(self._channel),
            "History": history_service_pb2_grpc.HistoryServiceStub(self._channel),
            "Journal": journal_service_pb2_grpc.JournalServiceStub(self._channel),
            "Telemetry": telemetry_service_pb2_grpc.TelemetryServiceStub(self._channel),
            "Trajectory": trajectory_service_pb2_grpc.TrajectoryServiceStub(self._channel),
        }
        self._open_calls: set[Any] = set()
        self._closed = False
        self.paused = False
        """Whether the cell is paused, as of the last answer. Robots' commands step a paused cell."""

    def _stub(self, service: calls.Service, method: str) -> Any:
        """Raises Unreachable after `close`."""
        if self._closed:
            raise self._closed_error()
        return getattr(self._stubs[service], method)

    def _closed_error(self) -> Unreachable:
        return Unreachable(f"this connection to the cell at {self._address} is closed")

    def _error(self, error: grpc.RpcError) -> AprsimError:
        if self._closed:
            return self._closed_error()
        status: Any = error
        return calls.error_of(status.code().name, status.details(), self._address)

    def _seen(self, snapshot: Snapshot) -> Snapshot:
        self.paused = snapshot.paused
        return snapshot

    def _cancel_open_calls(self) -> None:
        self._closed = True
        for call in list(self._open_calls):
            call.cancel()
        self._open_calls.clear()


def open_channel(endpoints: Endpoints, kind: Any) -> tuple[Any, str]:
    """The channel to a daemon, and its address. `kind`: the module grpc, or grpc.aio."""
    address = with_port(endpoints.host, endpoints.grpc)
    credentials = calls.credentials_of(endpoints)
    options = channel_options(endpoints.host)
    if credentials:
        return kind.secure_channel(address, credentials, options=options), address
    return kind.insecure_channel(address, options=options), address


def channel_options(host: str) -> list[tuple[str, int]]:
    """Channel arguments for a host. A cell on this machine is reached directly, not by the proxy of
    the environment."""
    options = [("grpc.max_receive_message_length", _MAX_MESSAGE_BYTES)]
    if any(os.environ.get(name) for name in _PROXY_VARIABLES) and is_this_machine(host):
        options.append(("grpc.enable_http_proxy", 0))
    return options
