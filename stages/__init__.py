"""One short script a stage, by the name that it has in dvc.yaml, params.yaml and reports/."""

import rallygap.pipeline  # noqa: F401  before numpy: it holds the arithmetic
