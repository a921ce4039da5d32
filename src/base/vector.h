// Loops that gain from wider vectors. VECTOR_CLONES before a function compiles it twice; which of
// the two runs is chosen when the program starts. Both give the same results to the bit: neither
// has instructions that fuse a product and a sum (tests/planet/test_vector.c). VECTOR_INLINE stands
// before what is to become part of them. Sanitizers cannot look into the choice, so there it is
// left out.
#ifndef PERIGEE_BASE_VECTOR_H
#define PERIGEE_BASE_VECTOR_H

#define VECTOR_INLINE static inline __attribute__((always_inline))

#ifndef VECTOR_CLONES
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) &&       \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define VECTOR_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define VECTOR_CLONES
#endif
#endif

#endif
