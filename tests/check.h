// The one small header of all tests: cmocka, and comparisons that print what they compared.
#ifndef PERIGEE_TESTS_CHECK_H
#define PERIGEE_TESTS_CHECK_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

// Fails unless |got - want| <= tol; NaN fails.
#define check_near(got, want, tol) check_near_at(__FILE__, __LINE__, #got, (got), (want), (tol))

static inline void check_near_at(const char *file, int line, const char *what, double got,
                                 double want, double tol)
{
    if (fabs(got - want) <= tol) return;
    print_error("%s: got %.17g, want %.17g, difference %g > %g\n", what, got, want, got - want,
                tol);
    _fail(file, line);
}

// Fails unless both files have the same bytes, and some; says where they differ.
#define check_same_files(a, b) check_same_files_at(__FILE__, __LINE__, (a), (b))

static inline void check_same_files_at(const char *file, int line, const char *a, const char *b)
{
    FILE *fa = fopen(a, "rb"), *fb = fopen(b, "rb");
    long at = -1;
    for (int x = 0, y = 0; fa && fb && x != EOF && x == y; at++) x = getc(fa), y = getc(fb);
    bool same = at > 0 && feof(fa) && feof(fb);
    if (fa) fclose(fa);
    if (fb) fclose(fb);
    if (same) return;
    print_error("%s and %s are not the same from byte %ld on\n", a, b, at);
    _fail(file, line);
}

// A small fixed-seed generator (xorshift64*), so that every failing case can be repeated.
struct check_random {
    uint64_t state;
};

static inline uint64_t check_random_u64(struct check_random *r)
{
    r->state ^= r->state >> 12;
    r->state ^= r->state << 25;
    r->state ^= r->state >> 27;
    return r->state * 0x2545F4914F6CDD1DULL;
}

static inline double check_random_range(struct check_random *r, double low, double high)
{
    return low + (high - low) * ((double)(check_random_u64(r) >> 11) * 0x1p-53);
}

#endif
