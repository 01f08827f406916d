"""Made-up causes and errors of an arena."""

import pandas as pd

CAUSES = pd.DataFrame(
    [
        ("drag", "cd", 0.4, 0.49, 0.48, 0.50, 0.491, 0.01),  # named, nine times the limit
        ("wind", "x", None, 0.1, 0.08, 0.09, 0.1, 0.02),  # named, not covered
        ("wind", "y", None, None, None, None, 0.01, 0.02),  # hidden, below the limit
        ("wind", "z", None, 0.3, 0.1, 0.4, 0.0, 0.2),  # made up
        ("net", "friction", None, 0.5, 0.45, 0.55, 0.51, None),
        ("racket_bounce", "kp", 1.0, 1.0, None, None, 2.0, None),
        ("camera_distortion", "amplitude", None, 0.002, 0.001, 0.003, None, None),
    ],
    columns=["effect", "parameter", "original", "amended", "low", "high", "truth", "detectable"],
)
ERRORS = pd.DataFrame(
    {
        "seed": 5,
        "predictor": [
            "imperfect_c", "imperfect_c_with_net", "transformer", "hybrid", "amended", "oracle",
        ],
        "horizon_ms": 300,
        "mean": [80.0, 60.0, 30.0, 22.0, 24.0, 20.0],
    }
)  # fmt: skip
