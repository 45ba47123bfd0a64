"""Vector fields of machines: Lie brackets, distributions and controllability."""

from kinolab.dynamics.analysis.fields.brackets import VectorField, lie_bracket
from kinolab.dynamics.analysis.fields.growth_vectors import (
    Filtration,
    filtration,
    growth_vector,
    word_text,
)
from kinolab.dynamics.analysis.fields.involutive import InvolutiveClosure, involutive_closure
from kinolab.dynamics.analysis.fields.linear_controllability import (
    LinearControllability,
    linear_controllability,
)
from kinolab.dynamics.analysis.fields.small_time import (
    SmallTime,
    SmallTimeVerdict,
    small_time_controllability,
)
from kinolab.dynamics.analysis.fields.system_fields import allowed_motions, vector_fields
from kinolab.dynamics.analysis.fields.vector_fields import VectorFields

__all__ = [
    "Filtration",
    "InvolutiveClosure",
    "LinearControllability",
    "SmallTime",
    "SmallTimeVerdict",
    "VectorField",
    "VectorFields",
    "allowed_motions",
    "filtration",
    "growth_vector",
    "involutive_closure",
    "lie_bracket",
    "linear_controllability",
    "small_time_controllability",
    "vector_fields",
    "word_text",
]
