"""What is said about kinolab's names, as Markdown."""
