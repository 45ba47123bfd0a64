"""What users add from outside: one file each, without an edit of the package."""
