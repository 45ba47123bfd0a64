"""The modelling vocabulary: symbols, frames, bodies, forces, inputs, constraints."""
