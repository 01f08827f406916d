"""MLflow: a run for each stage and trial, live metrics of trainings, and registered models."""

import logging
import os

# Read when mlflow is imported. Telemetry and addresses of runs on stdout, which may hold a
# password, stay off; the rest is the user's, if set.
ALWAYS = {
    "MLFLOW_DISABLE_TELEMETRY": "true",
    "DO_NOT_TRACK": "true",
    "MLFLOW_SUPPRESS_PRINTING_URL_TO_STDOUT": "true",
}
UNLESS_SET = {
    "MLFLOW_HTTP_REQUEST_MAX_RETRIES": "1",
    "MLFLOW_HTTP_REQUEST_TIMEOUT": "5",
    "MLFLOW_LOGGING_LEVEL": "CRITICAL",
    "PGCONNECT_TIMEOUT": "5",
}

os.environ.update(ALWAYS)
for _name, _value in UNLESS_SET.items():
    os.environ.setdefault(_name, _value)
logging.getLogger("urllib3.connectionpool").setLevel(logging.ERROR)  # it warns of every retry
