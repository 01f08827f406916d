"""What people read of the stages: tables and figures with their captions, on one page."""
