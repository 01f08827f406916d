"""One short script a stage; its name is also the stage in dvc.yaml, the key in params.yaml and the reports folder."""
