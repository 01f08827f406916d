"""The design: which questions the exam asks, and what their shots can show."""
