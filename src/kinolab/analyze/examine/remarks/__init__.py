"""What a remark is, of which machine, and where in its file."""
