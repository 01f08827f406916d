"""MLflow: a run for each stage and trial, live metrics of trainings, and registered models."""

import logging
import os

# Read when mlflow is imported. Telemetry and addresses of runs on stdout, which may hold a
# password, stay off.
os.environ.update(
    MLFLOW_DISABLE_TELEMETRY="true",
    DO_NOT_TRACK="true",
    MLFLOW_SUPPRESS_PRINTING_URL_TO_STDOUT="true",
)
# The rest is the user's, if set.
os.environ.setdefault("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "1")
os.environ.setdefault("MLFLOW_HTTP_REQUEST_TIMEOUT", "5")
os.environ.setdefault("MLFLOW_LOGGING_LEVEL", "CRITICAL")
os.environ.setdefault("PGCONNECT_TIMEOUT", "5")
logging.getLogger("urllib3.connectionpool").setLevel(logging.ERROR)  # it warns of every retry
