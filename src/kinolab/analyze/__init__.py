"""Analysis of machines, of failed searches, and of plans in closed-loop execution."""
