#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>

void *memory_new(size_t count, size_t size)
{
    void *p = calloc(count ? count : 1, size ? size : 1);
    if (p) return p;
    fprintf(stderr, "perigee: out of memory (%zu x %zu bytes)\n", count, size);
    abort();
}
