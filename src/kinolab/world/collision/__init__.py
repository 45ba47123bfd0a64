"""Contact, clearance and distance, by FCL and by proved bounds."""
