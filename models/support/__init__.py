"""What the models' code needs: compilation kept on disk, and plugins found by being there."""
