"""The example recordings, which are installed with the package."""

from importlib.resources import files
from pathlib import Path

from rallygap.pipeline.io.artifacts import replacing_files
from rallygap.pipeline.runtime.errors import InputError


def write_example(folder: Path) -> None:
    """Write the example recordings into a new folder (docs/examples/record_shots.py made them).

    Raises:
        InputError: there is such a folder or file, or it cannot be made.
    """
    if folder.exists():
        raise InputError(folder, "is there already; give a new folder")
    with replacing_files(folder) as written:
        for recording in files("rallygap").joinpath("examples", "recordings").iterdir():
            (written / recording.name).write_bytes(recording.read_bytes())
