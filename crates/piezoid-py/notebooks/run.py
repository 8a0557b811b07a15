"""Runs the notebooks, each in a folder of its own that goes away, and keeps what they show: `python run.py [paper ...]`.

The files stay the same from run to run: times, versions and what else depends on the machine is left out.
"""

from __future__ import annotations

import sys
from base64 import b64decode, b64encode
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import nbformat
from jupyter_client.kernelspec import KernelSpecManager
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from nbformat import NotebookNode
from PIL import Image

HERE = Path(__file__).parent
NAMES = ("paper", "compensate", "fleet")


def executed(name: str, folder: Path, after: str = "") -> NotebookNode:
    """A notebook as it comes out of this Python, run in `folder`, with one more cell at its end if `after` is given."""
    notebook = nbformat.read(HERE / f"{name}.ipynb", as_version=4)
    if after:
        notebook.cells.append(nbformat.v4.new_code_cell(after))
    # Of all the kernels there may be, that of this Python; it ends with the run.
    kernel = AsyncKernelManager(kernel_name="python3", kernel_spec_manager=KernelSpecManager(kernel_dirs=[]))
    place = {"metadata": {"path": str(folder)}}
    client = NotebookClient(notebook, km=kernel, timeout=300, resources=place, extra_arguments=["--log-level=ERROR"])
    client.owns_km = True
    client.execute()
    return notebook


def tidied(notebook: NotebookNode) -> NotebookNode:
    """The same without what changes from run to run or from machine to machine."""
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    for cell in notebook.cells:
        cell.metadata = {}
        for output in cell.get("outputs", []):
            output.get("metadata", {}).clear()
            data = output.get("data", {})
            if "image/png" in data:
                data["image/png"] = _small(data["image/png"])
    return notebook


def _small(png: str) -> str:
    """A picture in few colours, without its remarks, which name who drew it."""
    drawn, kept = Image.open(BytesIO(b64decode(png))), BytesIO()
    drawn.convert("RGB").quantize(64).save(kept, "png", optimize=True)
    return b64encode(kept.getvalue()).decode()


if __name__ == "__main__":
    for name in sys.argv[1:] or NAMES:
        with TemporaryDirectory() as folder:
            notebook = tidied(executed(name, Path(folder)))
        nbformat.write(notebook, HERE / f"{name}.ipynb")
