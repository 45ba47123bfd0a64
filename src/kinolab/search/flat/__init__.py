"""Trees in flat outputs: motions are polynomials, from which states and inputs follow.

Nothing is integrated while the trees grow; what they find is followed by the machine's own step at
the end, which is checked as the steps of all other trees are.

Source: Fliess, Levine, Martin, Rouchon, Int. J. Control 61(6), 1995; Duong et al., FLASK, 2026.
"""
