#include "$name.h"
#include <math.h>
#include <stddef.h>

const double ${name}_p[] = {$numbers};

static int all_finite(const double values[], size_t count) {
    int found = 1;
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(values[i])) {
            found = 0;
        }
    }
    return found;
}

static inline double sign(double value) {
    return (double)((value > 0.0) - (value < 0.0));
}

$functions
int ${name}_jacobian(const double x[], const double u[], const double p[], double out[]) {
    enum { N = $nx, COLUMNS = $columns };
    double along[COLUMNS] = {0.0};
    int status = 0;
    for (size_t k = 0; (k < COLUMNS) && (status == 0); ++k) {
        along[k] = 1.0;
        status = ${name}_tangent(x, u, p, along, along + N, out + (k * N));
        along[k] = 0.0;
    }
    return status;
}

$step {
    enum { N = $nx };
    static const double fractions[$stages] = {$fractions};
    static const double weights[$stages] = {$weights};
    double at[N];
    double slope[N] = {0.0};
    double total[N];
    int status = 0;
    for (size_t i = 0; i < N; ++i) {
        total[i] = x[i];
    }
    for (size_t stage = 0; (stage < ${stages}U) && (status == 0); ++stage) {
        for (size_t i = 0; i < N; ++i) {
            at[i] = x[i] + (h * fractions[stage]) * slope[i];
        }
        status = ${name}_f(at, u, p, slope);
        for (size_t i = 0; i < N; ++i) {
            total[i] = total[i] + (h * weights[stage]) * slope[i];
        }
    }
$landing
    return status;
}
