"""Tables of the documentation, each from the reports of the run that its docstring names."""
