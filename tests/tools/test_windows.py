# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

import pytest
from workshop import windows_wheels

ALIGNED = """
 3c: \tvmovaps %ymm6,0x20(%rsp)
 40: \tvmovdqa64 -0x80(%rbp),%zmm1
"""
UNALIGNED = """
 3c: \tvmovups %ymm6,0x20(%rsp)
 40: \tmovaps %xmm6,0x20(%rsp)
 44: \tvmovaps %ymm1,%ymm2
 48: \tvmovapd 0x1000(%rip),%ymm2
"""


@pytest.mark.parametrize(
    ("imported", "code", "complaint"),
    [
        ({"python311.dll", "kernel32.dll", "msvcrt.dll"}, UNALIGNED, None),
        ({"python311.dll", "libstdc++-6.dll"}, UNALIGNED, "libstdc"),
        ({"python313.dll"}, UNALIGNED, "python313.dll"),
        ({"python311.dll"}, ALIGNED, "2 aligned moves"),
    ],
)
def test_a_module_that_not_every_windows_could_run_is_refused(
    imported: set[str], code: str, complaint: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(windows_wheels, "imported_libraries", lambda module: imported)
    monkeypatch.setattr(windows_wheels, "disassembled", lambda module: code)
    if complaint is None:
        windows_wheels.check_module(Path("x.pyd"), 11)
    else:
        with pytest.raises(SystemExit, match=complaint):
            windows_wheels.check_module(Path("x.pyd"), 11)
