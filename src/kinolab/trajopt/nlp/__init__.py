"""The nonlinear program: decision variables, constraints and their derivatives."""
