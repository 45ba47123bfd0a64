"""What is drawn, as coloured triangles."""
