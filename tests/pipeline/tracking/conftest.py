"""MLflow is imported as stages import it: without its messages."""

import rallygap.pipeline.tracking  # noqa: F401
