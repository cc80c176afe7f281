# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what a Mach-O file tells macOS about itself: which Mac can load it, and what it needs there."""

import hashlib
import struct
from dataclasses import dataclass, field

ARM64 = 0x0100000C
LIBRARY = 6  # what Python loads is such a dynamic library, or a bundle
MACOS = 1
# Load commands
SYMBOLS, LOADS, LOADS_WEAKLY, RE_EXPORTS, RUN_PATH = 0x2, 0xC, 0x80000018, 0x8000001F, 0x8000001C
SIGNATURE, BUILT_FOR = 0x1D, 0x32
# Bits of a symbol
DEBUGGING, PRIVATE, KIND, EXTERNAL = 0xE0, 0x10, 0x0E, 0x01
WEAK_DEFINITION = 0x80
# Parts of a signature
ALL_PARTS, CODE_DIRECTORY, AD_HOC, SHA256 = 0xFADE0CC0, 0xFADE0C02, 0x2, 2


@dataclass
class MachO:
    processor: int
    kind: int
    platform: int = 0
    minimum: tuple[int, int] = (0, 0)  # the first macOS that loads it
    libraries: list[str] = field(default_factory=list)
    run_paths: list[str] = field(default_factory=list)  # where it looks for libraries beside the usual places
    # symbol -> its library; "" if any loaded one will do
    wanted: dict[str, str] = field(default_factory=dict)
    exported: set[str] = field(default_factory=set)
    shared: set[str] = field(default_factory=set)  # exported, and replaced by what another library defines
    signed: bool = False  # ad hoc, and the signature fits the file


def read(content: bytes) -> MachO:
    """Reads a file for one 64-bit processor with the lower byte first. Refuses every other one."""
    magic, processor, _, kind, count = struct.unpack_from("<5I", content)
    if magic != 0xFEEDFACF:
        raise ValueError("no 64-bit Mach-O file for one processor")
    found = MachO(processor, kind)
    commands, place = [], 32
    while len(commands) < count:
        command, size = struct.unpack_from("<2I", content, place)
        commands.append((command, content[place : place + size]))
        place += size
    for command, data in commands:
        if command == BUILT_FOR:
            found.platform, version = struct.unpack_from("<2I", data, 8)
            found.minimum = version >> 16, version >> 8 & 0xFF
        elif command in (LOADS, LOADS_WEAKLY, RE_EXPORTS):
            found.libraries.append(_text(data, *struct.unpack_from("<I", data, 8)))
        elif command == RUN_PATH:
            found.run_paths.append(_text(data, *struct.unpack_from("<I", data, 8)))
        elif command == SIGNATURE:
            found.signed = _fits(content, *struct.unpack_from("<2I", data, 8))
    for command, data in commands:
        if command == SYMBOLS:
            _read_symbols(found, content, *struct.unpack_from("<3I", data, 8))
    return found


def _read_symbols(found: MachO, content: bytes, start: int, count: int, names: int) -> None:
    for place in range(start, start + 16 * count, 16):
        name, bits, _, more, _ = struct.unpack_from("<IBBHQ", content, place)
        if bits & DEBUGGING or not bits & EXTERNAL or bits & PRIVATE:
            continue
        text = _text(content, names + name)
        if bits & KIND:
            found.exported.add(text)
            if more & WEAK_DEFINITION:
                found.shared.add(text)
        else:
            number = more >> 8  # counted from one; further numbers mean any library
            found.wanted[text] = found.libraries[number - 1] if 0 < number <= len(found.libraries) else ""


def _fits(content: bytes, start: int, size: int) -> bool:
    """Whether the signature holds the digests of all pages before it, and names nobody who signed."""
    signature = content[start : start + size]
    magic, _, count = struct.unpack_from(">3I", signature)
    parts = [struct.unpack_from(">2I", signature, 12 + 8 * k)[1] for k in range(count)]
    if magic != ALL_PARTS or not parts:
        return False
    code = signature[parts[0] :]
    magic, _, _, flags, digests, _, _, pages, end, size, kind, _, log_page = struct.unpack_from(">9I4B", code)
    if magic != CODE_DIRECTORY or kind != SHA256 or not flags & AD_HOC or end != start:
        return False
    step = 1 << log_page
    written = [code[digests + size * k : digests + size * (k + 1)] for k in range(pages)]
    computed = [hashlib.sha256(content[at : min(at + step, end)]).digest() for at in range(0, end, step)]
    return written == computed


def _text(data: bytes, start: int) -> str:
    return data[start : data.index(b"\0", start)].decode()
