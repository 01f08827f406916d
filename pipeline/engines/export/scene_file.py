"""The place of an amended scene: with other files of a user, which must stay."""

from pathlib import Path

from rallygap.pipeline.runtime.errors import InputError

SCENE = "scene.xml"
MARK = "<!-- rallygap: "  # of every amended scene


def check_place(scene: str, out: Path) -> None:
    """Raise unless an amended scene may be written to a folder.

    Args:
        scene: the user's, ``scene.xml`` or ``scene.xml#body``.
        out: the folder.

    Raises:
        InputError: the folder has the user's scene under the name of the amended one.
    """
    place, own = out / SCENE, Path(scene.partition("#")[0])
    if not place.is_file():
        return
    if not is_amended(place) or (own.is_file() and own.samefile(place)):
        problem = f"has a {SCENE} of yours, which would be replaced; give another folder"
        raise InputError(out, problem)


def former_scene(out: Path) -> list[str]:
    """Return the name of an earlier amended scene in a folder, if there is one."""
    return [SCENE] if is_amended(out / SCENE) else []


def is_amended(path: Path) -> bool:
    """Return whether a file is an amended scene."""
    return path.is_file() and MARK.encode() in path.read_bytes()
