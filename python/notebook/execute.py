"""Execute a notebook, and write the executed copy and its pictures beside each other.

Fails if a cell raises, or if a picture is missing.
"""

import base64
import sys
from pathlib import Path

import nbformat
from nbclient import NotebookClient

#: Pictures that the notebook draws.
PICTURES = 3

source, executed = map(Path, sys.argv[1:3])
notebook = nbformat.read(source, as_version=4)
NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
executed.parent.mkdir(parents=True, exist_ok=True)
nbformat.write(notebook, executed)
outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
data = [output["data"] for output in outputs if "image/png" in output.get("data", {})]
pictures = [one["image/png"] for one in data]
for number, picture in enumerate(pictures, 1):
    executed.with_name(f"{executed.stem}-{number}.png").write_bytes(base64.b64decode(picture))
errors = [output for output in outputs if output.get("name") == "stderr"]
if errors or len(pictures) != PICTURES:
    sys.exit(f"{len(pictures)} of {PICTURES} pictures; standard error: {errors}")
