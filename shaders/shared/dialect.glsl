// The dialect of shaders/shared: one source that is GLSL 4.50 and C. In GLSL `real` is float. In C the includer defines
// `real` (float or double) and SHARED_NAME(f), the name of a function in that precision; src/geo/shared.h does both.
// A shared function takes and gives scalars, uses + - * /, the functions listed here, if, for, ?: and #define constants,
// and writes every literal that is not an integer with the suffix f (exact values) or as REAL(x).
//   SHARED real SHARED_NAME(half_of)(real x)             a function
//   SHARED void SHARED_NAME(split)(real x, OUT(real) y)  an output, written as SET(y) = x;
//   SHARED_NAME(split)(x, REF(y))                        and received into a local variable
//   struct SHARED_NAME(pair) { real a, b; };             a type, named TYPE(pair)
//   UINT, UINT_OF(x), INT(x)                             whole numbers of 32 bits: the type, and casts
//   LEADING_BITS(x)                                      x cut to 12 bits in float; x itself in double
#ifndef SHARED_DIALECT
#define SHARED_DIALECT

#ifdef GL_core_profile

#define real           float
#define SHARED
#define SHARED_NAME(f) f
#define OUT(t)         out t
#define SET(n)         n
#define REF(n)         n
#define REAL(x)        float(x)
#define UINT           uint
#define UINT_OF(x)     uint(x)
#define INT(x)         int(x)
#define ATAN2(y, x)    atan(y, x)
#define TYPE(t)        t
#define LEADING_BITS(x) uintBitsToFloat(floatBitsToUint(x) & 0xfffff000u)

#else

#define SHARED      static inline
#define OUT(t)      t *
#define SET(n)      (*(n))
#define REF(n)      (&(n))
#define REAL(x)     ((real)(x))
#define UINT        uint32_t
#define UINT_OF(x)  ((uint32_t)(x))
#define INT(x)      ((int32_t)(x))
#define ATAN2(y, x) ((real)atan2(y, x))
#define TYPE(t)     struct SHARED_NAME(t)
#define LEADING_BITS(x) SHARED_NAME(leading_bits)(x)
#define acos(x)     ((real)(acos)(x))
#define cos(x)      ((real)(cos)(x))
#define floor(x)    ((real)(floor)(x))
#define sin(x)      ((real)(sin)(x))
#define sqrt(x)     ((real)(sqrt)(x))

#endif

#define SHARED_PI REAL(3.14159265358979323846)

#endif
