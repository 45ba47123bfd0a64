#include "$name.h"
#include <math.h>
#include <stdio.h>

static int failures = 0;

static void compare(int status, const double found[], const double wanted[],
                    int count, const char *what) {
    double largest = 1.0;
    for (int i = 0; i < count; ++i) {
        largest = fmax(largest, fabs(wanted[i]));
    }
    for (int i = 0; i < count; ++i) {
        const double gap = fabs(found[i] - wanted[i]);
        if ((status != 0) || !(gap <= 1e-12 * largest)) {
            (void)printf("%s, entry %d: %.17g, not %.17g\n", what, i, found[i],
                         wanted[i]);
            failures = failures + 1;
        }
    }
}

int main(void) {
    double out[$size];
$checks
    (void)printf("%d differences\n", failures);
    return (failures == 0) ? 0 : 1;
}
