// Small allocations: zeroed, and they abort when memory is out. Allocations sized by data use
// calloc and ERR_MEMORY.
#ifndef PERIGEE_BASE_MEMORY_H
#define PERIGEE_BASE_MEMORY_H

#include <stddef.h>

// count * size zeroed bytes; aborts with a message when refused or when the product overflows. Any
// thread.
void *memory_new(size_t count, size_t size);

#define NEW(type)          ((type *)memory_new(1, sizeof(type)))
#define NEW_ARRAY(type, n) ((type *)memory_new((n), sizeof(type)))

#endif
