"""Amended scenes are tested where MuJoCo is installed."""

from importlib.util import find_spec

collect_ignore_glob = [] if find_spec("mujoco") else ["test_scene_*.py"]
