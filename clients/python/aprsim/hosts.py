"""Names and addresses of hosts."""

from __future__ import annotations

import ipaddress
import socket

from .errors import BadArgument


def checked_host(host: str) -> str:
    """A host name, an IPv4 address, or an IPv6 address with or without brackets; the result has
    none. Raises BadArgument for anything else, as a host with a port."""
    out = host.strip()
    if out.startswith("[") and out.endswith("]"):
        out = out[1:-1]
        if ":" not in out:
            raise BadArgument(f"host: '{host}', where brackets hold an IPv6 address")
    if ":" in out:
        address = out.partition("%")[0]
        try:
            ipaddress.IPv6Address(address)
        except ValueError:
            raise BadArgument(
                f"host: '{host}', where a name or an address without a port is expected"
            ) from None
    if not out or any(character.isspace() or character in "/[]" for character in out):
        raise BadArgument(f"host: '{host}', where a name or an address is expected")
    return out


def with_port(host: str, port: int) -> str:
    """HOST:PORT, with brackets round an IPv6 address (RFC 3986, 3.2.2)."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def is_this_machine(host: str) -> bool:
    """Whether a name or an address leads to this machine: an address that a socket can be bound to.
    False for a name that cannot be resolved."""
    try:
        found = socket.getaddrinfo(host, 0, type=socket.SOCK_DGRAM)
    except OSError:
        return False
    for family, kind, protocol, _, address in found:
        try:
            with socket.socket(family, kind, protocol) as probe:
                probe.bind(address)
                return True
        except OSError:
            continue
    return False
