"""``rallygap export``: a list of effects in, a file for an engine or an amended scene out."""

from pathlib import Path

from rallygap.pipeline.engines.audited import cached_audit
from rallygap.pipeline.engines.export.code import CODE, ENGINES, SCENE, ball_effects
from rallygap.pipeline.engines.load import load_engine, names_scene
from rallygap.pipeline.io.artifacts import replacing_files, write_text
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import check_folder

MARK = b"<!-- rallygap: "  # of every amended scene


def export(simulator: str, engine: str, out: Path) -> None:
    """Write a simulator's flight and bounce as code for an engine.

    Args:
        simulator: name of a shipped one, or its YAML file, whose comments go into the code.
        engine: one of ``ENGINES``.
        out: file to write.

    Raises:
        InputError: the simulator cannot be read, there is no such engine, or the file cannot be
            written.
    """
    if engine not in ENGINES:
        raise InputError("--to", f"{engine} is no engine; give {' or '.join(ENGINES)}")
    try:
        write_text(out, code_of(simulator, engine))
    except OSError as error:
        raise InputError(out, f"cannot be written: {error.strerror}") from None


def export_scene(simulator: str, engine: str, scene: str, out: Path) -> tuple[str, ...]:
    """Write a scene amended by a list of effects, and code for it; return what they are worth.

    ``out`` gets scene.xml and ball_effects.py, both or none of them.

    Args:
        simulator: name of a shipped one, or its YAML file, whose comments go into both files.
        engine: of the scene, ``mujoco``.
        scene: of MuJoCo, ``scene.xml`` or ``scene.xml#body``.
        out: folder to write to.

    Returns:
        Sentences: what is changed, what has no attribute, and what the verification shows.

    Raises:
        InputError: the list or the scene cannot be used, or the folder cannot be written to.
    """
    if engine != "mujoco":
        raise InputError("--scene", f"is for --to mujoco, not {engine}")
    if not names_scene(scene):
        raise InputError("--scene", f"{scene} is no scene of MuJoCo; give scene.xml")
    check_folder(out)
    check_place(scene, out)
    after = load_simulator(simulator)
    before = cached_audit(load_engine(scene)).simulator
    from rallygap.pipeline.engines.export.scene.amended_scene import amended_scene

    code, comments = code_of(simulator, "mujoco"), _comments(simulator)
    amended = amended_scene(scene, before, after, code, comments)
    if amended.text is None:
        assert amended.problem is not None  # it says why
        raise amended.problem
    with replacing_files(out) as folder:
        write_text(folder / SCENE, amended.text)
        write_text(folder / CODE, amended.code)
    return amended.sentences


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
    if not former_scene(out) or (own.is_file() and own.samefile(place)):
        problem = f"has a {SCENE} of yours, which would be replaced; give another folder"
        raise InputError(out, problem)


def former_scene(out: Path) -> list[str]:
    """Return the name of an earlier amended scene in a folder, if there is one."""
    place = out / SCENE
    return [SCENE] if place.is_file() and MARK in place.read_bytes() else []


def code_of(simulator: str, engine: str) -> str:
    """Return a simulator's flight and bounce as code for an engine, as ``export`` takes them.

    Raises:
        InputError: the simulator cannot be read.
    """
    known = load_simulator(simulator)
    return ball_effects(known, Path(simulator).name, _comments(simulator), engine)


def comments_of(text: str) -> list[str]:
    """Return the comments of a list of effects: where its values come from."""
    return [line.removeprefix("# ") for line in text.splitlines() if line.startswith("# ")]


def _comments(simulator: str) -> list[str]:
    if not simulator.endswith((".yaml", ".yml")):
        return []
    return comments_of(Path(simulator).read_text(encoding="utf-8"))
