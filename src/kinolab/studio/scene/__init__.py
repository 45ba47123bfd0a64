"""What is open in the studio, and what its page shows: nodes, gizmos and inputs."""
