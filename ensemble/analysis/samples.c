#include "ensemble/analysis/samples.h"

#include <stdlib.h>

void rk_samples_clear(struct rk_samples *samples) {
    free(samples->values);
    free(samples->lengths);
    free(samples->beds);
    *samples = (struct rk_samples){0};
}
