"""Addresses of a daemon's listeners, and the credentials of a client."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field, replace
from pathlib import Path

from . import arguments
from .errors import AprsimError
from .hosts import checked_host

PORTS_FILE_VARIABLE = "APRSIM_PORTS_FILE"
TOKEN_VARIABLE = "APRSIM_TOKEN"
CA_VARIABLE = "APRSIM_CA"
CERTIFICATE_VARIABLE = "APRSIM_CERTIFICATE"
KEY_VARIABLE = "APRSIM_KEY"
_CRCL = "crcl."


@dataclass(frozen=True)
class Encryption:
    """Encryption of gRPC; the values are PEM texts."""

    ca: bytes | None = None
    """Authorities of the daemon's certificate; None = those of the system."""
    certificate: bytes | None = None
    """Certificate of this client."""
    key: bytes | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Endpoints:
    """Host, ports and credentials; the defaults are the daemon's."""

    host: str = "127.0.0.1"
    grpc: int = 50051
    crcl: dict[str, int] = field(default_factory=lambda: {"fanuc": 64444, "motoman": 64445})
    """CRCL ports by robot name."""
    ports: dict[str, int] = field(default_factory=dict)
    """All ports of the ports file by their keys, as `modbus` or `motion.fanuc`; empty without a file."""
    token: str = field(default="", repr=False)
    """Token that is sent with every call; empty = none."""
    encryption: Encryption | None = None
    """None = gRPC is not encrypted."""
    file: Path | None = None
    """The ports file that they are from; None = they are from none."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "host", checked_host(self.host))
        arguments.whole("grpc_port", self.grpc, 1, 65535)
        for robot, port in self.crcl.items():
            arguments.whole(f"crcl_ports['{robot}']", port, 1, 65535)

    def renewed(self) -> Endpoints:
        """The same with the present ports of the file: other scenes have other robots. Host, gRPC and
        credentials stay."""
        if self.file is None:
            return self
        try:
            found = read_ports_file(self.file)
        except AprsimError:
            return self  # the daemon has ended
        return replace(self, crcl=found.crcl, ports=found.ports)

    def crcl_port(self, robot: str) -> int:
        """Raises AprsimError with the names there are."""
        if robot not in self.crcl:
            raise AprsimError(f"no robot '{robot}'; there is {', '.join(self.crcl) or 'none'}")
        return self.crcl[robot]


def read_ports_file(path: str | Path) -> Endpoints:
    """Read a file that `aprsimd --ports-file` has written. The result has the robots of the file only.
    Raises AprsimError with file, key, value and the expected value."""
    try:
        ports = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise AprsimError(f"cannot read the ports file {path}: {error.strerror}") from error
    except ValueError as error:
        raise AprsimError(f"{path} is not a ports file: {error}") from error
    if not isinstance(ports, dict):
        raise AprsimError(f"{path} is not a ports file: not a JSON object")

    def port(key: str) -> int:
        value = ports[key]
        if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= 65535:
            raise AprsimError(f'{path}: "{key}" is {value!r}, not a port 1..65535')
        return value

    robots = {key.removeprefix(_CRCL): port(key) for key in ports if key.startswith(_CRCL)}
    return Endpoints(
        grpc=port("grpc") if "grpc" in ports else Endpoints.grpc,
        crcl=robots,
        ports={key: port(key) for key in ports if key != "pid" and _is_port(ports[key])},
        file=Path(path),
    )


def _is_port(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= 65535


def find_endpoints(
    ports_file: str | Path | None = None,
    *,
    host: str | None = None,
    grpc: int | None = None,
    crcl: dict[str, int] | None = None,
    token_file: str | Path | None = None,
    tls: bool = False,
    ca: str | Path | None = None,
    certificate: str | Path | None = None,
    key: str | Path | None = None,
) -> Endpoints:
    """Endpoints from the ports file, else from the file in APRSIM_PORTS_FILE, else the default ports.
    `host`, `grpc` and `crcl` override them. The token is the first line of `token_file`, else
    APRSIM_TOKEN. gRPC is encrypted with `tls`, or with a file in an argument or in APRSIM_CA,
    APRSIM_CERTIFICATE or APRSIM_KEY."""
    file = ports_file or os.environ.get(PORTS_FILE_VARIABLE)
    found = read_ports_file(file) if file else Endpoints()
    return Endpoints(
        host=host or found.host,
        grpc=found.grpc if grpc is None else grpc,
        crcl={**found.crcl, **(crcl or {})},
        ports=found.ports,
        file=found.file,
        token=_read_token(token_file),
        encryption=_read_encryption(tls, ca, certificate, key),
    )


def _read_encryption(
    tls: bool,
    ca: str | Path | None,
    certificate: str | Path | None,
    key: str | Path | None,
) -> Encryption | None:
    texts = [
        _read_pem(path or os.environ.get(variable))
        for path, variable in (
            (ca, CA_VARIABLE),
            (certificate, CERTIFICATE_VARIABLE),
            (key, KEY_VARIABLE),
        )
    ]
    if (texts[1] is None) != (texts[2] is None):
        raise AprsimError("a client's certificate and its key go together")
    return Encryption(*texts) if tls or any(texts) else None


def _read_pem(path: str | Path | None) -> bytes | None:
    if not path:
        return None
    try:
        text = Path(path).read_bytes()
    except OSError as error:
        raise AprsimError(f"cannot read {path}: {error.strerror}") from error
    if b"-----BEGIN " not in text:
        raise AprsimError(f"{path} holds nothing in PEM")
    return text


def _read_token(path: str | Path | None) -> str:
    if path is None:
        token, origin = os.environ.get(TOKEN_VARIABLE, ""), TOKEN_VARIABLE
    else:
        origin = str(path)
        try:
            with open(path, encoding="utf-8", errors="replace") as file:
                token = file.readline().rstrip("\r\n")
        except OSError as error:
            raise AprsimError(f"cannot read a token from {path}: {error.strerror}") from error
    if not all(" " <= character <= "~" for character in token):
        # The message must not show it.
        raise AprsimError(f"the token of {origin} is not of ASCII characters")
    return token
