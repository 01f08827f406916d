"""``rallygap export``: a list of effects in, a file for an engine or an amended scene out."""

from pathlib import Path

from rallygap.pipeline.engines.audited import audited
from rallygap.pipeline.engines.export.code import CODE, ENGINES, ball_effects
from rallygap.pipeline.engines.export.scene_file import SCENE, check_place
from rallygap.pipeline.engines.load import load_engine, names_scene
from rallygap.pipeline.io.artifacts import replacing_files, write_text
from rallygap.pipeline.io.simulators import load_simulator
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.paths import check_folder


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
        Sentences: what is changed, what is not said, and what the verification shows.

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
    before = audited(load_engine(scene)).simulator
    from rallygap.pipeline.engines.export.scene.handover import handed_over

    comments, code = _comments(simulator), code_of(simulator, "mujoco")
    handed = handed_over(scene, before, after, code, comments)
    with replacing_files(out) as folder:
        assert handed.scene is not None  # otherwise there is an error
        write_text(folder / SCENE, handed.scene)
        write_text(folder / CODE, handed.code)
    return handed.sentences


def code_of(simulator: str, engine: str) -> str:
    """Return a simulator's flight and bounce as code for an engine.

    Args:
        simulator: name of a shipped one, or its YAML file, whose comments go into the code.
        engine: one of ``ENGINES``.

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
