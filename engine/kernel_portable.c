#include <stdbool.h>

static bool usable(void) {
    return true;
}

#define KERNEL_NAME "portable"
#define KERNEL_DOC "plain C for any processor"
#define KERNEL_TABLE rk_kernel_portable
#define KERNEL_USABLE usable
#include "engine/kernel_body.h"
