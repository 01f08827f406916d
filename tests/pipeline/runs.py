"""What a repository's MLflow store holds."""

from mlflow import MlflowClient


def store(repository):
    """A client of the store that the stages of a repository write."""
    return MlflowClient(f"sqlite:///{repository / 'mlflow.db'}")


def runs(repository, query, **options):
    """The runs that a query finds; options are those of MLflow's ``search_runs``."""
    client = store(repository)
    (experiment,) = client.search_experiments(filter_string="name = 'rallygap'")
    return client.search_runs([experiment.experiment_id], query, **options)
