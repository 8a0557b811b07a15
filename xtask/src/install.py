"""What `maturin develop` does, except for the build: installs what the package in a folder and its extras need, and
makes the folder importable."""

import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path

folder = Path(sys.argv[1])
project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
extras = [name for extra in sys.argv[2:] for name in project["optional-dependencies"][extra]]
subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", *project["dependencies"], *extras], check=True)
Path(sysconfig.get_path("purelib"), "piezoid.pth").write_text(str(folder / "python"))
