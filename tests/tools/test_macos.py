# SPDX-License-Identifier: GPL-3.0-or-later
"""What is checked of a module for macOS, on small files that are made here."""

import hashlib
import struct
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import pytest
from workshop import cross_wheels, mach_o, macos_wheels
from workshop.archives import write_wheel

PAGE = 4096


class Module:
    """A Mach-O file in the making, by default one that every Mac with an Apple processor loads."""

    def __init__(self) -> None:
        self.processor = mach_o.ARM64
        self.kind = mach_o.LIBRARY
        self.minimum = 11 << 16
        self.libraries = ["/usr/lib/libSystem.B.dylib"]
        self.run_paths: list[str] = []
        # name, bits, section, further bits
        self.symbols = [
            ("_PyInit_sinew_native", 0x0F, 1, 0),
            ("_PyLong_FromLong", 0x01, 0, 0xFE << 8),
            ("_malloc", 0x01, 0, 1 << 8),
            ("__ZN5sinew6hiddenE", 0x1F, 1, 0x80),
            ("__ZdlPv", 0x0F, 1, 0x80),
        ]
        self.inside = b"code" * 2000
        self.signed = True

    def write(self) -> bytes:
        names = b"\0" + b"".join(name.encode() + b"\0" for name, *_ in self.symbols)
        commands = [struct.pack("<6I", mach_o.BUILT_FOR, 24, mach_o.MACOS, self.minimum, self.minimum, 0)]
        commands += [_path(mach_o.LOADS, path) for path in self.libraries]
        commands += [_path(mach_o.RUN_PATH, path) for path in self.run_paths]
        start = 32 + sum(map(len, commands)) + 24 + 16
        table, text = start + len(self.inside), start + len(self.inside) + 16 * len(self.symbols)
        end = text + len(names)
        commands.append(struct.pack("<6I", mach_o.SYMBOLS, 24, table, len(self.symbols), text, len(names)))
        signature = 64 + 32 * -(-end // PAGE)
        commands.append(struct.pack("<4I", mach_o.SIGNATURE, 16, end, signature))
        place, rows = 1, b""
        for name, bits, section, more in self.symbols:
            rows += struct.pack("<IBBHQ", place, bits, section, more, 0)
            place += len(name) + 1
        size = sum(map(len, commands))
        head = struct.pack("<8I", 0xFEEDFACF, self.processor, 0, self.kind, len(commands), size, 0, 0)
        content = head + b"".join(commands) + self.inside + rows + names
        assert len(content) == end
        return content + (_signature(content) if self.signed else bytes(signature))


def _path(command: int, path: str) -> bytes:
    head = 24 if command == mach_o.LOADS else 12
    text = path.encode() + b"\0"
    text += bytes(-(head + len(text)) % 8)
    return struct.pack("<3I", command, head + len(text), head) + bytes(head - 12) + text


def _signature(content: bytes) -> bytes:
    pages = [content[at : at + PAGE] for at in range(0, len(content), PAGE)]
    digests = b"".join(hashlib.sha256(page).digest() for page in pages)
    numbers = (mach_o.CODE_DIRECTORY, 44 + len(digests), 0x20400, mach_o.AD_HOC, 44, 44, 0, len(pages))
    code = struct.pack(">9I4BI", *numbers, len(content), 32, mach_o.SHA256, 0, 12, 0)
    return struct.pack(">5I", mach_o.ALL_PARTS, 20 + len(code) + len(digests), 1, 0, 20) + code + digests


def _changed(**values: object) -> Callable[[Module], None]:
    return lambda module: module.__dict__.update(values)


def _with(name: str, bits: int, more: int) -> Callable[[Module], None]:
    return lambda module: module.symbols.append((name, bits, 1 if bits & 0xE else 0, more))


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (_changed(), None),
        (_changed(processor=0x01000007), "no library for Apple's processors"),
        (_changed(kind=2), "no library for Apple's processors"),
        (_changed(minimum=14 << 16 | 2 << 8), r"\(14, 2\)"),
        (_changed(libraries=["/usr/lib/libSystem.B.dylib", "/usr/lib/libc++.1.dylib"]), "libc"),
        (_changed(run_paths=["/opt/homebrew/lib"]), "/opt/homebrew/lib"),
        (_with("_openblas_get_parallel", 0x01, 0xFE << 8), "nothing defines _openblas_get_parallel"),
        (_with("__ZN3tbb1fEv", 0x0F, 0x80), "may replace its __ZN3tbb1fEv"),
        (lambda module: module.symbols.pop(0), "cannot initialise"),
        (_changed(inside=f"{macos_wheels.ROOT}/native/a.cpp".encode()), "it names"),
        (_changed(signed=False), "signature"),
    ],
)
def test_a_module_that_not_every_mac_could_load_is_refused(
    change: Callable[[Module], None], complaint: str | None, tmp_path: Path
) -> None:
    module = Module()
    change(module)
    (tmp_path / "a.so").write_bytes(module.write())
    with pytest.raises(SystemExit, match=complaint) if complaint else nullcontext():
        macos_wheels.check_module(tmp_path / "a.so", 11)


def test_a_module_that_was_changed_after_it_was_signed_is_refused() -> None:
    content = bytearray(Module().write())
    content[PAGE + 10] ^= 1
    assert macos_wheels.flaws(bytes(content)) == ["its signature is missing or wrong"]


def test_what_is_no_file_for_a_mac_is_refused() -> None:
    with pytest.raises(ValueError, match="no 64-bit Mach-O"):
        mach_o.read(b"\x7fELF" + bytes(100))


@pytest.mark.parametrize(("tag", "right"), [("macosx_11_0_arm64", True), ("linux_x86_64", False)])
def test_a_wheel_says_inside_what_its_name_says(tag: str, right: bool, tmp_path: Path) -> None:
    about = f"Wheel-Version: 1.0\nRoot-Is-Purelib: false\nTag: cp311-cp311-{tag}\n"
    files = {"sinew.dist-info/WHEEL": about.encode(), "sinew.dist-info/RECORD": b""}
    wheel = write_wheel(tmp_path / "sinew_native-0.1.0-cp311-cp311-macosx_11_0_arm64.whl", files)
    with nullcontext() if right else pytest.raises(SystemExit, match="does not say"):
        cross_wheels.check(macos_wheels.TARGET, wheel, 11)
    assert wheel.is_file() is right
