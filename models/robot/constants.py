"""All constants of the robot, in the table frame (models/ball/state.py), in SI units.

The arm stands behind the end at y < 0 and plays towards +y. A bridge runs along the table and
carries a carriage across it; on the carriage stand an upper arm, a forearm, a wrist and the racket.
Frames of the links are parallel to the table frame when every pitch is zero: x across, y ahead,
z up. A positive pitch leans a link back and opens the racket's face.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from rallygap.models.ball.types import Floats, Vector

COMMAND_STEP = 0.020  # s between two commands to the joints: 50 Hz, slow for an industrial drive
BULLET_STEP = 0.004  # s; five to a command, and a joint turns at most 2 degrees in one

BASE: Vector = (0.0, -1.90, -0.22)  # m: 0.53 m behind the end, 0.54 m above the floor
UPPER_ARM = 0.35  # m from shoulder to elbow: a stretched arm, 0.82 m, still reaches over the table
FOREARM = 0.35  # m from elbow to wrist
BLADE: Vector = (0.0, 0.06, 0.10)  # m from the wrist to the racket's centre
RACKET_RADIUS = 0.08  # m: a disc for the common blade of 150 mm by 158 mm

# m, of the table's top and the steel frame beneath: thick enough that a racket does not pass it in
# one step.
TABLE_DEPTH = 0.06
FLOOR = -0.76  # m: ITTF Law 2.1.1, the playing surface is 0.76 m above the floor


@dataclass(frozen=True)
class Solid:
    """A homogeneous primitive body in the frame of its link."""

    shape: Literal["box", "cylinder"]
    # m; a box's full lengths (x, y, z), or a cylinder's radius and length along its z
    size: tuple[float, ...]
    mass: float  # kg
    position: Vector = (0.0, 0.0, 0.0)  # m, of its centre
    pitch: float = 0.0  # rad about x, from the link's axes to the solid's


@dataclass(frozen=True)
class Joint:
    """A driven joint and the link that it moves."""

    name: str
    kind: Literal["prismatic", "revolute"]
    # of the joint's frame, along which it slides or about which it turns
    axis: Literal["x", "y", "z"]
    lower: float  # end of the joint's range, m or rad; neutral is zero
    upper: float  # other end of the range, m or rad
    speed: float  # largest command to the drive, m/s or rad/s
    force: float  # of the drive, N or N m
    link: tuple[Solid, ...]  # the solids that it moves
    origin: Vector = (0.0, 0.0, 0.0)  # m, of the joint in the frame of the link before it
    # rad about x, from the frame of the link before it to the joint's at zero
    pitch: float = 0.0


_ALONG_Y = -math.pi / 2  # pitch of a cylinder whose axis is the link's y

_BRIDGE = (Solid("box", (1.90, 0.08, 0.06), mass=8.0, position=(0.0, 0.0, -0.09)),)
_CARRIAGE = (Solid("box", (0.16, 0.14, 0.12), mass=4.0),)
_UPPER_ARM = (Solid("cylinder", (0.04, UPPER_ARM), mass=1.5, position=(0, 0, UPPER_ARM / 2)),)
_FOREARM = (Solid("cylinder", (0.03, FOREARM), mass=1.0, position=(0, 0, FOREARM / 2)),)
_WRIST = (Solid("cylinder", (0.03, 0.06), mass=0.3),)
_RACKET = (
    Solid("cylinder", (0.010, 0.06), mass=0.05, position=(0, 0.03, 0), pitch=_ALONG_Y),
    Solid("cylinder", (0.014, 0.06), mass=0.05, position=(0, 0.06, 0)),  # the grip
    # wood and two rubbers
    Solid("cylinder", (RACKET_RADIUS, 0.012), mass=0.15, position=BLADE, pitch=_ALONG_Y),
)
_ELBOW, _WRIST_YAW = (0.0, 0.0, UPPER_ARM), (0.0, 0.0, FOREARM)  # m, origins of these joints

# The drives of the gantry accelerate what they carry, 15.05 and 7.05 kg, at 20 and 30 m/s^2: belt
# axes of that size do. Those of the arm hold 2.4 to 3.0 times what gravity asks of them when all
# beyond them is stretched out level. Ranges: the bridge stays clear of the table, the carriage
# spans its width; the arm neither folds into itself nor reaches the floor.
# Pitches: the shoulder leans back, so that the elbow is behind the racket; the forearm is a little
# above level; the wrist's yaw undoes both, so that its axis is upright in neutral; the face is open
# by 11 degrees, as for a block.
JOINTS = (  # name, kind, axis, lower, upper, speed, force, link, origin and pitch
    Joint("bridge", "prismatic", "y", -0.35, 0.45, 2.0, 300.0, _BRIDGE),
    Joint("carriage", "prismatic", "x", -0.8, 0.8, 3.0, 210.0, _CARRIAGE),
    Joint("shoulder", "revolute", "x", -1.2, 1.2, 6.0, 32.0, _UPPER_ARM, pitch=0.35),
    Joint("elbow", "revolute", "x", -1.5, 1.5, 6.0, 9.0, _FOREARM, _ELBOW, pitch=-1.7),
    Joint("wrist_yaw", "revolute", "z", -1.3, 1.3, 8.0, 0.6, _WRIST, _WRIST_YAW, pitch=1.35),
    Joint("wrist_pitch", "revolute", "x", -1.5, 1.5, 8.0, 0.6, _RACKET, pitch=0.2),
)

# The rails on which the bridge runs, on posts from the floor. They do not move.
BASE_SOLIDS = tuple(
    solid
    for x in (-0.90, 0.90)
    for solid in (
        Solid("box", (0.06, 0.92, 0.04), mass=5.0, position=(x, 0.05, -0.14)),
        Solid("box", (0.06, 0.06, 0.38), mass=2.0, position=(x, -0.37, -0.35)),
        Solid("box", (0.06, 0.06, 0.38), mass=2.0, position=(x, 0.47, -0.35)),
    )
)

LOWER: Floats = np.array([joint.lower for joint in JOINTS])  # (6,) m, rad
UPPER: Floats = np.array([joint.upper for joint in JOINTS])  # (6,) m, rad
SPEED: Floats = np.array([joint.speed for joint in JOINTS])  # (6,) m/s, rad/s
FORCE: Floats = np.array([joint.force for joint in JOINTS])  # (6,) N, N m
NEUTRAL: Floats = np.zeros(len(JOINTS))  # (6,) where the arm waits, the racket at (0, -1.64, 0.30)
