"""The audit: which effects an engine really has, by probe shots, before any measurement."""
