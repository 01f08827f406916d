"""What sim-to-real compares: settings, the baseline, and how the protocols are called."""

from rallygap.pipeline.transfer.replay_trials import EVERY_STEP, ONCE

SETTING = ["set", "horizons_ms"]  # of a comparison
PHYSICS = "physics"
BASELINE = {"predictor": PHYSICS, "protocol": EVERY_STEP}  # of gains
PROTOCOLS = {ONCE: "first window", EVERY_STEP: "every control step"}
