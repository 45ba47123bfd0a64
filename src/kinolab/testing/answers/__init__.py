"""What is asked of an answer, and how it is judged."""
