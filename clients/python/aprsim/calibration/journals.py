"""Records of journal files, without a daemon."""

from __future__ import annotations

import ctypes
import ctypes.util
import functools
from pathlib import Path
from typing import Any, Iterator

from google.protobuf.message import DecodeError

from ..errors import AprsimError, BadArgument
from ..v1 import journal_pb2

_SKIPPABLE = b"\x50\x2a\x4d\x18"
_MARK = b"APRSIMJ1"
_CHUNK = 1 << 17


def is_journal(beginning: bytes) -> bool:
    """Whether a file with this beginning is a journal."""
    return beginning.startswith(_SKIPPABLE) and _MARK in beginning[:16]


def records(place: Path) -> Iterator[Any]:
    """The records of a journal: of a file, or of all files of one run in a directory. Raises BadArgument."""
    files = [place]
    if place.is_dir():
        files = sorted(
            (file for file in place.iterdir() if file.is_file() and is_journal(file.read_bytes()[:16])),
            key=lambda file: int(next(_records_of(file)).header.part),
        )
        runs = {next(_records_of(file)).header.run_id for file in files}
        if len(runs) != 1:
            raise BadArgument(f"{place}: journals of {len(runs)} runs, where those of one are expected")
    for file in files:
        yield from _records_of(file)


def _records_of(file: Path) -> Iterator[Any]:
    """The records of one file, up to its last complete frame."""
    try:
        packed = file.read_bytes()
    except OSError as error:
        raise BadArgument(f"{file}: {error.strerror}") from error
    if not is_journal(packed[:16]):
        raise BadArgument(f"{file}: no journal")
    data = b""
    for piece in _unpacked(packed):
        data += piece
        offset = 0
        while (place := _length_at(data, offset)) is not None:
            begin, end = place
            if end > len(data):
                break
            try:
                yield journal_pb2.JournalRecord.FromString(data[begin:end])
            except DecodeError as error:
                raise BadArgument(f"{file}: a damaged record") from error
            offset = end
        data = data[offset:]


def _length_at(data: bytes, offset: int) -> tuple[int, int] | None:
    """Beginning and end of the record whose varint of length begins here; None when it is cut off."""
    length = shift = 0
    for at in range(offset, min(offset + 5, len(data))):
        length |= (data[at] & 0x7F) << shift
        shift += 7
        if data[at] < 0x80:
            return at + 1, at + 1 + length
    return None


class _Buffer(ctypes.Structure):
    _fields_ = [("data", ctypes.c_void_p), ("size", ctypes.c_size_t), ("pos", ctypes.c_size_t)]


@functools.cache
def _zstd() -> Any:
    name = ctypes.util.find_library("zstd") or "libzstd.so.1"
    try:
        library = ctypes.CDLL(name)
    except OSError as error:
        raise AprsimError(f"journals need zstd's library: {error}") from error
    library.ZSTD_createDStream.restype = ctypes.c_void_p
    library.ZSTD_freeDStream.argtypes = [ctypes.c_void_p]
    library.ZSTD_decompressStream.argtypes = [
        ctypes.c_void_p,
        ctypes.POINTER(_Buffer),
        ctypes.POINTER(_Buffer),
    ]
    library.ZSTD_decompressStream.restype = ctypes.c_size_t
    library.ZSTD_isError.argtypes = [ctypes.c_size_t]
    return library


def _unpacked(packed: bytes) -> Iterator[bytes]:
    """The contents of all frames, one piece after the other; it ends where the file is cut off."""
    zstd = _zstd()
    stream = zstd.ZSTD_createDStream()
    source = ctypes.create_string_buffer(packed, len(packed))
    target = ctypes.create_string_buffer(_CHUNK)
    input_ = _Buffer(ctypes.addressof(source), len(packed), 0)
    try:
        while True:
            output = _Buffer(ctypes.addressof(target), _CHUNK, 0)
            before = input_.pos
            code = zstd.ZSTD_decompressStream(stream, ctypes.byref(output), ctypes.byref(input_))
            if zstd.ZSTD_isError(code):
                return
            if output.pos:
                yield target.raw[: output.pos]
            elif input_.pos in (before, len(packed)):
                return
    finally:
        zstd.ZSTD_freeDStream(stream)
