"""What may happen between the samples of a motion: boxes, peaks, speeds and clearances."""
