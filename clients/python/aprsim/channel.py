"""A channel to the cell: what the blocking and the asyncio cell have in common."""

from __future__ import annotations

from typing import Any

from . import calls
from .endpoints import Endpoints
from .errors import AprsimError
from .snapshots import Snapshot
from .v1 import (
    control_service_pb2_grpc,
    history_service_pb2_grpc,
    journal_service_pb2_grpc,
    telemetry_service_pb2_grpc,
)


class Channel:
    """The channel with its services, what goes with every call, and what is known of the cell."""

    def __init__(self, endpoints: Endpoints, kind: Any) -> None:
        """`kind`: the module grpc, or grpc.aio."""
        self.endpoints = endpoints
        self._address = f"{endpoints.host}:{endpoints.grpc}"
        credentials = calls.credentials_of(endpoints)
        self._channel: Any = (
            kind.secure_channel(self._address, credentials, options=calls.CHANNEL_OPTIONS)
            if credentials
            else kind.insecure_channel(self._address, options=calls.CHANNEL_OPTIONS)
        )
        self._metadata = calls.metadata_of(endpoints)
        self._stubs: dict[calls.Service, Any] = {
            "Control": control_service_pb2_grpc.ControlServiceStub(self._channel),
            "History": history_service_pb2_grpc.HistoryServiceStub(self._channel),
            "Journal": journal_service_pb2_grpc.JournalServiceStub(self._channel),
            "Telemetry": telemetry_service_pb2_grpc.TelemetryServiceStub(self._channel),
        }
        self.paused = False
        """As this client has last seen or made it. Robots' commands step a paused cell."""

    def _error(self, error: Any) -> AprsimError:
        return calls.error_of(error.code().name, error.details(), self._address)

    def _seen(self, snapshot: Snapshot) -> Snapshot:
        self.paused = snapshot.paused
        return snapshot
