"""The design: which parameters and questions the exam asks, and what their shots can show."""
