"""The studio without a browser: text, edits, meaning, files and searches."""
