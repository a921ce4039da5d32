// The shared functions as the GPU computes them, over the cases of the CPU's test (tests/geo),
// against two truths: the same source compiled in double, and the plain formulas in long double.
// Errors on the ground are in texels of a window of 256 rows over the level's diameter, errors of
// position in shares of the distance. Each bound stands beside what was measured on llvmpipe.
#include "check.h"

#include <stdbool.h>

#include "geo/ring_truth.h"
#include "geo/shared.h"
#include "gpu/gpu_fixture.h"
#include "gpu/shared_kernel.h"

// Measured on llvmpipe, where the GPU's floats are C's to the last bit: 4.4e-5 texel, 1.8e-7 of the
// distance, 1.6e-7 relative, 6e-8 relative (one multiplication), 3.3e-4 rad (acos near 1). Other
// devices divide and take roots to 2.5 ulp and have an acos off by 1.6e-4: the bounds leave room.
#define STABLE_BOUND   3e-4
#define POSITION_BOUND 4e-7
#define ATAN_BOUND     5e-7
#define PRODUCT_BOUND  2.4e-7
#define PAPER_BOUND    2e-3

static struct shared_inputs *inputs;
static struct shared_outputs *outputs;
static struct check_random dice = {7};

static void fill_inputs(int i)
{
    struct shared_case c = shared_case_at(i);
    struct shared_inputs *in = &inputs[i];
    *in = shared_inputs_of(&c);
    float x = (float)check_random_range(&dice, -1, 1), y = (float)check_random_range(&dice, -1, 1);
    int shift = (int)(check_random_u64(&dice) % 60);
    in->tan_x = i % 4 == 1 ? ldexpf(x, -shift) : x;
    in->tan_y = i % 4 == 2 ? ldexpf(y, -shift) : i % 4 == 3 ? x * (1 + 1e-3f * y) : y;
}

static int compute(void **state)
{
    (void)state;
    inputs = calloc(SHARED_CASES, sizeof *inputs);
    outputs = calloc(SHARED_CASES, sizeof *outputs);
    if (!inputs || !outputs) return -1;
    for (int i = 0; i < SHARED_CASES; i++) fill_inputs(i);
    return shared_kernel_run(inputs, outputs, SHARED_CASES) ? -1 : 0;
}

static int release(void **state)
{
    (void)state;
    free(inputs);
    free(outputs);
    return 0;
}

// The larger, NaN winning, so that a NaN from the GPU never looks like an exact result.
static double worse(double worst, double error)
{
    return isnan(worst) || error <= worst ? worst : error;
}

static void check_bound(const char *what, double worst, double bound)
{
    print_message("%-48s %.3g (bound %.3g)\n", what, worst, bound);
    if (!(worst <= bound)) fail_msg("%s: %g > %g", what, worst, bound);
}

static double texel(int i)
{
    int level = shared_case_at(i).level;
    return 2 * M_PI * ldexp(1, -level) / 256;
}

struct plain {
    exact u[3]; // unit vector of the vertex, meridian frame
    exact d[3]; // vertex minus focus, unit sphere
    exact rho;  // distance of u from the axis
    exact dlon, dlat;
};

static struct plain plain_map(const struct shared_inputs *in)
{
    exact n = in->n, e = in->e, v = in->v, cb = in->cb, sb = in->sb, r = in->r;
    struct plain p = {.d = {-sb * n - cb * v, e, cb * n - sb * v}};
    p.u[0] = cb + p.d[0], p.u[1] = p.d[1], p.u[2] = sb + p.d[2];
    p.rho = hypotl(p.u[0], p.u[1]);
    p.dlon = atan2l(p.u[1], p.u[0]);
    p.dlat = atan2l(r * p.u[2], p.rho) - atan2l(r * sb, cb);
    return p;
}

// At a pole itself there is no longitude.
static bool has_longitude(int i, const struct plain *p)
{
    return p->rho > 1e-6L * exp2l(-shared_case_at(i).level);
}

static void test_stable(void **state)
{
    (void)state;
    double lon_source = 0, lat_source = 0, lon_plain = 0, lat_plain = 0, lat_cpu = 0;
    for (int i = 0; i < SHARED_CASES; i++) {
        const struct shared_inputs *in = &inputs[i];
        const float *got = outputs[i].stable;
        struct plain p = plain_map(in);
        double dlon, dlat, unit = texel(i), ground = (double)p.rho / unit;
        float cpu[2];
        map_transform_stable_d(in->n, in->e, in->v, in->cb, in->sb, in->r, &dlon, &dlat);
        map_transform_stable_f(in->n, in->e, in->v, in->cb, in->sb, in->r, &cpu[0], &cpu[1]);
        lat_source = worse(lat_source, fabs(got[1] - dlat) / unit);
        lat_plain = worse(lat_plain, (double)fabsl(got[1] - p.dlat) / unit);
        lat_cpu = worse(lat_cpu, fabs((double)got[1] - cpu[1]) / unit);
        if (!has_longitude(i, &p)) continue;
        lon_source = worse(lon_source, fabs(got[0] - dlon) * ground);
        lon_plain = worse(lon_plain, (double)fabsl(got[0] - p.dlon) * ground);
    }
    print_message("%d cases; stable latitude on the GPU and in C float differ by %.3g texel\n",
                  SHARED_CASES, lat_cpu);
    check_bound("stable, longitude, same source (texel)", lon_source, STABLE_BOUND);
    check_bound("stable, latitude, same source (texel)", lat_source, STABLE_BOUND);
    check_bound("stable, longitude, plain (texel)", lon_plain, STABLE_BOUND);
    check_bound("stable, latitude, plain (texel)", lat_plain, STABLE_BOUND);
}

static struct place_frame_d in_double(const struct place_frame_f *f)
{
    enum { MEMBERS = sizeof *f / sizeof(float) };
    float from[MEMBERS];
    double to[MEMBERS];
    struct place_frame_d d;
    memcpy(from, f, sizeof *f);
    for (int i = 0; i < MEMBERS; i++) to[i] = from[i];
    memcpy(&d, to, sizeof d);
    return d;
}

// Of the terrain over the place that the case's floats name, seen from the camera.
static void plain_position(int i, exact out[3])
{
    struct shared_case c = shared_case_at(i);
    struct truth_focus f = {c.ellipsoid, c.colatitude, c.hemisphere};
    struct ring_truth t = ring_truth_stored(&f, (float[3]){c.n, c.e, c.v});
    exact focus[3], camera[3], p[3];
    ring_truth_focus(&f, focus);
    ring_truth_point(c.ellipsoid, focus, c.href, camera);
    ring_truth_point(c.ellipsoid, t.u, c.h, p);
    for (int k = 0; k < 3; k++) p[k] -= camera[k];
    ring_truth_tangent(&f, p, out);
}

static void test_position(void **state)
{
    (void)state;
    double source = 0, plain = 0;
    for (int i = 0; i < SHARED_CASES; i++) {
        const struct shared_inputs *in = &inputs[i];
        const float *got = outputs[i].position;
        double same[3], off_same = 0, off_plain = 0, length = 0;
        exact want[3];
        relative_position_d(in_double(&in->place), in->n, in->e, in->v, in->h, &same[0], &same[1],
                            &same[2]);
        plain_position(i, want);
        for (int k = 0; k < 3; k++) {
            off_same = hypot(off_same, got[k] - same[k]);
            off_plain = hypot(off_plain, (double)(got[k] - want[k]));
            length = hypot(length, (double)want[k]);
        }
        source = worse(source, off_same / length);
        plain = worse(plain, off_plain / length);
    }
    check_bound("position, same source (share of distance)", source, POSITION_BOUND);
    check_bound("position, plain (share of distance)", plain, POSITION_BOUND);
}

static void test_atan(void **state)
{
    (void)state;
    double source = 0, plain = 0;
    for (int i = 0; i < SHARED_CASES; i++) {
        double y = inputs[i].tan_y, x = inputs[i].tan_x, want = atan2(y, x);
        if (want == 0) continue;
        source = worse(source, fabs(outputs[i].atan / atan_ratio_d(y, x) - 1));
        plain = worse(plain, fabs(outputs[i].atan / want - 1));
    }
    check_bound("atan_ratio, same source (relative)", source, ATAN_BOUND);
    check_bound("atan_ratio, atan2 of libm (relative)", plain, ATAN_BOUND);
}

// Built-in functions, whose precision GLSL leaves open: their error is told, and only nonsense is
// refused.
static void test_paper(void **state)
{
    (void)state;
    double exact_lon = 0, exact_lat = 0, approx = 0, blend_lon = 0, blend_lat = 0;
    for (int i = 0; i < SHARED_CASES; i++) {
        const struct shared_inputs *in = &inputs[i];
        const struct shared_outputs *got = &outputs[i];
        struct plain p = plain_map(in);
        double ex[2], ap[2], bl[2];
        map_transform_exact_d(in->n, in->e, in->v, in->cb, in->sb, in->r, in->lat, &ex[0], &ex[1]);
        map_transform_approx_d(in->n, in->e, in->v, in->stretch, in->dlat_db, &ap[0], &ap[1]);
        map_transform_blend_d(in->n, in->e, in->v, in->cb, in->sb, in->r, in->lat, in->stretch,
                              in->dlat_db, in->w, &bl[0], &bl[1]);
        exact_lat = worse(exact_lat, fabs(got->exact[1] - ex[1]));
        blend_lat = worse(blend_lat, fabs(got->blend[1] - bl[1]));
        for (int k = 0; k < 2; k++)
            if (ap[k] != 0) approx = worse(approx, fabs(got->approx[k] / ap[k] - 1));
        if (!has_longitude(i, &p)) continue;
        double rho = (double)p.rho;
        exact_lon = worse(exact_lon, fabs(remainder(got->exact[0] - ex[0], 2 * M_PI)) * rho);
        double whole = fabs(ap[0]) + M_PI;
        blend_lon = worse(blend_lon, fabs(got->blend[0] - bl[0]) / whole * rho);
    }
    check_bound("exact, longitude on the ground (rad)", exact_lon, PAPER_BOUND);
    check_bound("exact, latitude (rad)", exact_lat, PAPER_BOUND);
    check_bound("approx (relative)", approx, PRODUCT_BOUND);
    check_bound("blend, longitude (share of its terms)", blend_lon, PAPER_BOUND);
    check_bound("blend, latitude (rad)", blend_lat, PAPER_BOUND);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stable),
        cmocka_unit_test(test_position),
        cmocka_unit_test(test_atan),
        cmocka_unit_test(test_paper),
    };
    int rc = gpu_fixture_open();
    if (rc) return rc;
    return gpu_fixture_close(cmocka_run_group_tests(tests, compute, release));
}
