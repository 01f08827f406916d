"""The ball's state, its body and the table it plays on.

A ball state is nine numbers ``[p, v, w]``: position (m), velocity (m/s), spin (rad/s), in the
table frame: origin at the centre of the playing surface, x across the table, y along it, z up.
The surface is z = 0, so a ball at rest on the table has its centre at ``BALL_RADIUS``.
"""

import math

# Columns of a state.
POSITION = slice(0, 3)
VELOCITY = slice(3, 6)
SPIN = slice(6, 9)
STATE_SIZE = 9

# The ball: ITTF Law 2.3 (40 mm, 2.7 g). A thin shell has I = 2/3 m r^2.
BALL_MASS = 2.7e-3  # kg
BALL_RADIUS = 0.020  # m
BALL_VOLUME = 4.0 / 3.0 * math.pi * BALL_RADIUS**3  # m^3
BALL_AREA = math.pi * BALL_RADIUS**2  # m^2

# Air at 20 degrees and 1013 hPa.
AIR_DENSITY = 1.2  # kg/m^3

# The table: ITTF Laws 2.1 and 2.2.
TABLE_HALF_LENGTH = 1.37  # m, along y
TABLE_HALF_WIDTH = 0.7625  # m, along x
NET_HEIGHT = 0.1525  # m
NET_OVERHANG = 0.1525  # m, beyond each side line

# Factors of the equations of motion (Nakashima 2010).
DRAG_FACTOR = AIR_DENSITY * BALL_AREA / (2 * BALL_MASS)  # 1/m: kD = DRAG_FACTOR * C_D
MAGNUS_FACTOR = AIR_DENSITY * BALL_VOLUME / BALL_MASS  # kM = MAGNUS_FACTOR * C_M, dimensionless
