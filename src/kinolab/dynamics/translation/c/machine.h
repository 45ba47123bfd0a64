/* Equations of motion of $name, derived by kinolab. Units are SI. */
#ifndef ${upper}_H
#define ${upper}_H

$sizes

/* x: $states
   u: $inputs
   p: $parameters
   A function returns 0; 1 where the state is singular; 2 where a result is not
   finite. The Jacobian of f has a column for each x, then one for each u; the mass
   matrix is that of $rates. */
#ifdef __cplusplus
extern "C" {
#endif
extern const double ${name}_p[];  /* default parameters */
$signatures
#ifdef __cplusplus
}
#endif

#endif /* ${upper}_H */
