"""Plans made to be proved for all machines within some bounds."""
