"""What sim-to-real compares: settings, the baseline, and how the protocols are called."""

from rallygap.pipeline.transfer.replay_trials import EveryStep, FirstWindow

SETTING = ["set", "horizons_ms"]  # of a comparison
PHYSICS = "physics"
BASELINE = {"predictor": PHYSICS, "protocol": EveryStep.protocol}  # of gains
PROTOCOLS = {FirstWindow.protocol: "first window", EveryStep.protocol: "every control step"}
