# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import hashlib
import os
import time
from pathlib import Path

import pytest
from workshop.archives import read_zip, write_wheel, write_zip
from workshop.isolation import OWNED, RENAMED


def test_zip_has_the_same_bytes_at_another_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = write_zip(tmp_path / "a.zip", {"b": b"2", "a": b"1" * 999}).read_bytes()
    monkeypatch.setenv("TZ", "Asia/Tokyo")
    time.tzset()
    old_mask = os.umask(0o077)
    second = write_zip(tmp_path / "b.zip", {"a": b"1" * 999, "b": b"2"}).read_bytes()
    os.umask(old_mask)
    assert first == second
    assert read_zip(tmp_path / "b.zip") == {"a": b"1" * 999, "b": b"2"}


def test_a_zip_is_replaced_at_once_or_not_at_all(tmp_path: Path) -> None:
    """Another command may read it at any moment, also while it is packed again or its packing fails."""
    old, new = {"a": b"old", "b": b"old"}, {"a": b"new", "b": b"new"}
    target = write_zip(tmp_path / "a.zip", old)

    class AnotherReads(dict[str, bytes]):
        def __getitem__(self, name: str) -> bytes:
            assert read_zip(target) == old
            return super().__getitem__(name)

    with pytest.raises(TypeError):
        write_zip(target, AnotherReads(a=b"new", b=None))
    assert read_zip(target) == old
    write_zip(target, AnotherReads(new))
    assert read_zip(target) == new
    assert [file.name for file in tmp_path.iterdir()] == ["a.zip"]


def test_wheel_records_every_file(tmp_path: Path) -> None:
    files = {"x.so": b"machine code", "x-1.dist-info/WHEEL": b"", "x-1.dist-info/RECORD": b"out of date"}
    record = read_zip(write_wheel(tmp_path / "x.whl", files))["x-1.dist-info/RECORD"].decode().splitlines()
    digest = base64.urlsafe_b64encode(hashlib.sha256(b"machine code").digest()).rstrip(b"=").decode()
    assert f"x.so,sha256={digest},12" in record
    assert "x-1.dist-info/RECORD,," in record
    assert len(record) == 3


def test_what_a_host_may_bring_too_is_renamed_and_what_is_of_the_system_or_the_compiler_stays() -> None:
    brought = ("dgemm_", "openblas_set_num_threads", "cholmod_start", "_ZN3tbb6detail2r115spawnEv")
    own = ("_ZNSt6vectorIiE", "_ZTISt9exception", "_ZNKSt5ctypeIcE", "_init", "_edata")
    assert all(map(RENAMED.match, brought))
    assert not any(map(RENAMED.match, own))
    assert all(map(OWNED.match, ("libopenblasp-r0.so", "libccolamd.so.2", "libtbb-1.so.12")))
    assert not any(map(OWNED.match, ("libgomp.so.1", "libgfortran.so")))
