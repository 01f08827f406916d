"""What every stage shares: parameters, data contracts, sources, artefacts, tracking, figures."""
