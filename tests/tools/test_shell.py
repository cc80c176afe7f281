# SPDX-License-Identifier: GPL-3.0-or-later
import os
import subprocess
import tempfile
import time
from pathlib import Path

import pytest
from workshop import shell
from workshop.places import BUILD, ROOT


def test_late_command_is_stopped_with_all_it_started(tmp_path: Path) -> None:
    pid_file = tmp_path / "pid"
    start = time.monotonic()
    status = shell.run(["bash", "-c", f"sleep 60 & echo $! > {pid_file}; wait"], timeout=1)
    assert status == shell.TIMED_OUT
    assert time.monotonic() - start < 20
    child = Path("/proc") / pid_file.read_text().strip() / "stat"
    for _ in range(50):
        if not child.exists() or child.read_text().rsplit(")", 1)[1].split()[0] == "Z":
            return
        time.sleep(0.1)
    pytest.fail("the child still runs")


def test_quiet_command_shows_its_output_only_when_it_fails(capsys: pytest.CaptureFixture[str]) -> None:
    assert shell.run(["bash", "-c", "echo fine"], quiet=True) == 0
    assert capsys.readouterr().err == ""
    assert shell.run(["bash", "-c", "echo broken; exit 3"], quiet=True) == 3
    assert "broken" in capsys.readouterr().err


def test_strays_of_the_callers_environment_stay_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", "/elsewhere")
    monkeypatch.setenv("LD_LIBRARY_PATH", "/elsewhere")
    assert "LD_LIBRARY_PATH" not in shell.environment()
    assert shell.environment({"PYTHONPATH": "/here"})["PYTHONPATH"] == "/here"


def test_what_two_trees_compile_alike_is_compiled_once(tmp_path: Path) -> None:
    """Also what lies in the trees themselves, as generated sources do, and what uses precompiled headers."""
    cache = {"CCACHE_DIR": tmp_path / "cache"}
    compiler = ["ccache", "g++", "-fpch-preprocess", "-MD"]
    with tempfile.TemporaryDirectory(dir=BUILD) as trees:
        for name in ("developer", "wheel"):
            tree = Path(trees) / name
            tree.mkdir()
            (tree / "all.h").write_text("#include <vector>\n")
            (tree / "kernel.cpp").write_text("std::vector<int> kernel() { return {1}; }\n")
            header = [*compiler, "-x", "c++-header", "-c", tree / "all.h", "-o", "all.h.gch"]
            source = [*compiler, "-include", tree / "all.h", "-c", tree / "kernel.cpp", "-o", "kernel.o"]
            assert [shell.run(command, cwd=tree, env=cache) for command in (header, source)] == [0, 0]
    asked = subprocess.run(
        ["ccache", "--print-stats"], env=os.environ | cache, capture_output=True, text=True
    )
    counts = dict(line.split("\t") for line in asked.stdout.splitlines())
    assert (counts["cache_miss"], counts["direct_cache_hit"]) == ("2", "2")


def test_stamp_is_fresh_until_an_input_changes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shell, "ROOT", tmp_path)
    source = tmp_path / "native" / "a.cpp"
    source.parent.mkdir()
    source.write_text("1")
    first = shell.fingerprint([tmp_path / "native"], "cp311")
    stamp = shell.Stamp(tmp_path / "stamp", first)
    assert not stamp.is_fresh()
    stamp.write()
    assert stamp.is_fresh()
    source.write_text("2")
    assert not shell.Stamp(tmp_path / "stamp", shell.fingerprint([tmp_path / "native"], "cp311")).is_fresh()
    source.write_text("1")
    assert shell.fingerprint([tmp_path / "native"], "cp313") != first
    assert shell.fingerprint([tmp_path / "native"], "cp311") == first


@pytest.mark.skipif(os.getuid() != 0, reason="gives its rights away, which takes root")
def test_missing_package_without_rights_says_what_to_type() -> None:
    nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "env", "PATH=/usr/bin:/bin"]
    script = (ROOT / "tools/workshop/apt_install").read_text()
    command = [*nobody, "bash", "-c", 'command() { [ $2 != sudo ] && builtin command "$@"; }; ' + script, "x"]
    answer = subprocess.run([*command, "no-such-package"], capture_output=True, text=True)
    assert answer.returncode == 1
    assert "apt-get install --no-install-recommends no-such-package" in answer.stderr


def test_present_packages_need_no_word() -> None:
    answer = subprocess.run([ROOT / "tools/workshop/apt_install", "bash"], capture_output=True, text=True)
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
