"""Files that pass between stages: artefacts, table schemas, episodes, simulators."""
