// What synthesis adds below the data at one place: noise on a lattice in space, and how much of it the ground bears.
// One source for the tiles (src/planet/synthesis.c), the GPU and the tests' double precision.
#ifndef SHARED_SYNTHESIS
#define SHARED_SYNTHESIS

#include "shared/dialect.glsl"

#define NOISE_PRIME_X 0x9e3779b1u
#define NOISE_PRIME_Y 0x85ebca77u
#define NOISE_PRIME_Z 0xc2b2ae3du
#define NOISE_GRADIENT_SCALE REAL(0.010706638) /* 1 / rms of the raw noise: components uniform in [-511.5, 511.5] */
#define STRIPE_WAVE REAL(0.9)  /* cycles a cell, across the slope */
#define STRIPE_SCALE REAL(1.55)  /* 1 / rms of what SOFT_NOUGHT leaves */
#define STRIPE_FLOOR REAL(0.04) /* of the squared length of the mean phase: where it vanishes, a calm spot, no crease */
#define STRIPE_ROUND REAL(0.35) /* of the relief: a gradient shorter than this has no direction to speak of */

#define SHARPEN REAL(0.8)       /* of the convexity: what a zoom loses of its ridges and gullies by being a mean */
#define SHARPEN_MOST REAL(1.2)  /* of the amplitude */

// An integer hash in two rounds.
SHARED UINT SHARED_NAME(noise_mix)(UINT h)
{
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    h ^= h >> 13;
    h *= 0x297a2d39u;
    return h;
}

SHARED real SHARED_NAME(noise_fade)(real t)
{
    return t * t * (REAL(3.0) - REAL(2.0) * t);
}

SHARED real SHARED_NAME(noise_lerp)(real a, real b, real t)
{
    return a + t * (b - a);
}

// The hashed lattice gradient times the offset from its corner.
SHARED real SHARED_NAME(noise_corner)(UINT hash, real x, real y, real z)
{
    UINT h = SHARED_NAME(noise_mix)(hash);
    real gx = REAL(INT(h >> 22)) - REAL(511.5);
    real gy = REAL(INT(h >> 12 & 1023u)) - REAL(511.5);
    real gz = REAL(INT(h >> 2 & 1023u)) - REAL(511.5);
    return gx * x + gy * y + gz * z;
}

// Gradient noise, mean 0, rms 1, C1. hx, hy, hz: the cell's whole coordinates times the primes; x, y, z in [0, 1): place
// in the cell.
//   source  Perlin 1985, "An image synthesizer", with hashed gradients
SHARED real SHARED_NAME(gradient_noise)(UINT hx, UINT hy, UINT hz, real x, real y, real z)
{
    UINT bx = hx + NOISE_PRIME_X, by = hy + NOISE_PRIME_Y, bz = hz + NOISE_PRIME_Z;
    real u = SHARED_NAME(noise_fade)(x), v = SHARED_NAME(noise_fade)(y), w = SHARED_NAME(noise_fade)(z);
    real x1 = x - REAL(1.0), y1 = y - REAL(1.0), z1 = z - REAL(1.0);
    real low = SHARED_NAME(noise_lerp)(
        SHARED_NAME(noise_lerp)(SHARED_NAME(noise_corner)((hx ^ hy) + hz, x, y, z),
                                SHARED_NAME(noise_corner)((bx ^ hy) + hz, x1, y, z), u),
        SHARED_NAME(noise_lerp)(SHARED_NAME(noise_corner)((hx ^ by) + hz, x, y1, z),
                                SHARED_NAME(noise_corner)((bx ^ by) + hz, x1, y1, z), u), v);
    real high = SHARED_NAME(noise_lerp)(
        SHARED_NAME(noise_lerp)(SHARED_NAME(noise_corner)((hx ^ hy) + bz, x, y, z1),
                                SHARED_NAME(noise_corner)((bx ^ hy) + bz, x1, y, z1), u),
        SHARED_NAME(noise_lerp)(SHARED_NAME(noise_corner)((hx ^ by) + bz, x, y1, z1),
                                SHARED_NAME(noise_corner)((bx ^ by) + bz, x1, y1, z1), u), v);
    return NOISE_GRADIENT_SCALE * SHARED_NAME(noise_lerp)(low, high, w);
}

// sin(2 pi t) of a phase of 32 bits that counts a turn, to 0.0011: two parabolas.
SHARED real SHARED_NAME(stripe_wave)(UINT phase)
{
    real t = REAL(INT(phase)) * REAL(4.656612873077393e-10); /* [-1, 1) */
    real y = t * (REAL(4.0) - REAL(4.0) * (t < REAL(0.0) ? -t : t));
    return y * (REAL(0.775) + REAL(0.225) * (y < REAL(0.0) ? -y : y));
}

// Stripes that run square to the wave vector k (cycles a cell), with ends and forks where the lattice's random phases
// disagree: mean 0, rms near 1 where |k| is STRIPE_WAVE, |stripes| <= STRIPE_SCALE, C1 where k is. Other arguments as
// above. Each corner of the cell sends a wave of its own phase; what is taken is the phase of their weighted mean, of
// nearly constant height.
SHARED real SHARED_NAME(stripe_noise)(UINT hx, UINT hy, UINT hz, real x, real y, real z, real kx, real ky, real kz)
{
    UINT bx = hx + NOISE_PRIME_X, by = hy + NOISE_PRIME_Y, bz = hz + NOISE_PRIME_Z;
    UINT at = UINT_OF(INT((kx * x + ky * y + kz * z) * REAL(16777216.0))) << 8;
    UINT px = UINT_OF(INT(kx * REAL(16777216.0))) << 8, py = UINT_OF(INT(ky * REAL(16777216.0))) << 8;
    UINT pz = UINT_OF(INT(kz * REAL(16777216.0))) << 8;
    real u = SHARED_NAME(noise_fade)(x), v = SHARED_NAME(noise_fade)(y), w = SHARED_NAME(noise_fade)(z);
    UINT p000 = at + SHARED_NAME(noise_mix)((hx ^ hy) + hz), p100 = at - px + SHARED_NAME(noise_mix)((bx ^ hy) + hz);
    UINT p010 = at - py + SHARED_NAME(noise_mix)((hx ^ by) + hz);
    UINT p110 = at - px - py + SHARED_NAME(noise_mix)((bx ^ by) + hz);
    UINT p001 = at - pz + SHARED_NAME(noise_mix)((hx ^ hy) + bz);
    UINT p101 = at - px - pz + SHARED_NAME(noise_mix)((bx ^ hy) + bz);
    UINT p011 = at - py - pz + SHARED_NAME(noise_mix)((hx ^ by) + bz);
    UINT p111 = at - px - py - pz + SHARED_NAME(noise_mix)((bx ^ by) + bz);
    real s = SHARED_NAME(noise_lerp)(
        SHARED_NAME(noise_lerp)(
            SHARED_NAME(noise_lerp)(SHARED_NAME(stripe_wave)(p000), SHARED_NAME(stripe_wave)(p100), u),
            SHARED_NAME(noise_lerp)(SHARED_NAME(stripe_wave)(p010), SHARED_NAME(stripe_wave)(p110), u), v),
        SHARED_NAME(noise_lerp)(
            SHARED_NAME(noise_lerp)(SHARED_NAME(stripe_wave)(p001), SHARED_NAME(stripe_wave)(p101), u),
            SHARED_NAME(noise_lerp)(SHARED_NAME(stripe_wave)(p011), SHARED_NAME(stripe_wave)(p111), u), v), w);
    UINT q = 0x40000000u; /* a quarter turn: the cosines */
    real c = SHARED_NAME(noise_lerp)(
        SHARED_NAME(noise_lerp)(
            SHARED_NAME(noise_lerp)(SHARED_NAME(stripe_wave)(p000 + q), SHARED_NAME(stripe_wave)(p100 + q), u),
            SHARED_NAME(noise_lerp)(SHARED_NAME(stripe_wave)(p010 + q), SHARED_NAME(stripe_wave)(p110 + q), u), v),
        SHARED_NAME(noise_lerp)(
            SHARED_NAME(noise_lerp)(SHARED_NAME(stripe_wave)(p001 + q), SHARED_NAME(stripe_wave)(p101 + q), u),
            SHARED_NAME(noise_lerp)(SHARED_NAME(stripe_wave)(p011 + q), SHARED_NAME(stripe_wave)(p111 + q), u), v), w);
    return STRIPE_SCALE * s / sqrt(s * s + c * c + STRIPE_FLOOR);
}

// Relief (m a sample) as far as finer detail follows it: beyond `steep` ever less, as the steeper
// ground is the less rough beside its slope; `least` is the relief that no ground is without.
SHARED real SHARED_NAME(synthesis_tempered)(real relief, real steep, real least)
{
    real h2 = relief * relief + least * least;
    return relief > REAL(0.0) ? sqrt(h2 / (REAL(1.0) + h2 / (steep * steep))) : REAL(0.0);
}

// Length of the wave vector of the stripes, cycles a cell, over the gradient's length in metres a sample.
// Where the ground is all but level the waves grow long, for its direction is chance. `least` as above.
SHARED real SHARED_NAME(stripe_number)(real north, real east, real relief, real least)
{
    real round2 = STRIPE_ROUND * STRIPE_ROUND * (relief * relief + least * least);
    return STRIPE_WAVE / sqrt(north * north + east * east + round2 + REAL(1e-20));
}

// What is added, in metres: `bend` is the mean of the neighbours less the sample, `amplitude` the rms to add in all, noise
// of rms 1. Ridges grow and gullies deepen by what `bend` says they have lost, the noise adds what is left to add.
SHARED real SHARED_NAME(synthesis_eroded)(real bend, real amplitude, real noise)
{
    real most = SHARPEN_MOST * amplitude, sharp = -SHARPEN * bend;
    real bound = sqrt(sharp * sharp + most * most + REAL(1e-20));
    sharp = sharp * most / bound;
    real rest = amplitude * amplitude - sharp * sharp, least = REAL(0.25) * amplitude * amplitude;
    return sharp + sqrt(rest > least ? rest : least) * noise;
}

// The height `up` changed by `change`, but never lower than `base`, the lowest ground around: no valley is dug below its
// own floor. Both are what is there before; C1 in `change`. What rounding leaves above the floor is none of it: level
// water is told by equal heights, whatever the processor's divisions are rounded to.
SHARED real SHARED_NAME(synthesis_limited)(real up, real base, real change)
{
    real from = base > up ? base : up, room = from - base;
    real down = change < REAL(0.0) ? -change : REAL(0.0);
    real h = from + (change + down) - down * room / (room + down + REAL(1e-20));
    real tiny = REAL(1e-5) + REAL(5e-7) * (base < REAL(0.0) ? -base : base);
    return h - base > tiny ? h : base;
}

#endif
