"""The environment of `side_by_side.py`: bench/.venv, one thread."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import venv
from pathlib import Path

BENCH = Path(__file__).resolve().parent.parent
ROOT = BENCH.parent
HOME = BENCH / ".venv"
ONE_THREAD = dict.fromkeys(
    ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"], "1"
)


def processor() -> str:
    """The name of the processor, or of its architecture if the name is unknown."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def inside(needs: list[str]) -> None:
    """Restarts the script in bench/.venv, which is created on the first run, with `needs` from the package index and
    piezoid of this checkout, built on every start.
    """
    python = HOME / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if Path(sys.prefix).resolve() == HOME.resolve():
        return
    install = [str(python), "-m", "pip", "install", "--quiet"]
    there = HOME / "ready"
    installed = there.read_text().split() if there.exists() else []
    if missing := [need for need in needs if need not in installed]:
        print(f"into {HOME.relative_to(ROOT)} go {', '.join(missing)}", file=sys.stderr)
        if not installed:
            venv.create(HOME, with_pip=True, clear=True)
        subprocess.run([*install, *missing], check=True)
        there.write_text("\n".join(installed + missing))
    subprocess.run([*install, "--force-reinstall", "--no-deps", str(ROOT / "crates/piezoid-py")], check=True)
    raise SystemExit(subprocess.run([str(python), *sys.argv], env={**os.environ, **ONE_THREAD}).returncode)
