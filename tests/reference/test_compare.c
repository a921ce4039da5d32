// The judge's measures on pictures whose differences are known in closed form: spheres, walls and
// bumps drawn here without the reference; then the reference against itself turned by half a pixel,
// which on any terrain is an error of half a pixel and no more.
#include "check.h"

#include "planet/planet_fixture.h"
#include "reference/compare.h"
#include "reference/geographic.h"

enum { W = 320, H = 240, N = W * H };

#define RADIUS 6371000.0

static float za[N], zb[N], normal[3][N], color_a[3][N], color_b[3][N];
static compare_maps maps;
static float geometric[N], depth[N], silhouette[N];
static unsigned char kind[N];

static compare_params params_of(double alt, double pitch, double fov)
{
    return (compare_params){.ellipsoid = {RADIUS, RADIUS},
                            .camera = {0, 0, alt, 0, pitch, 0, fov},
                            .width = W,
                            .height = H,
                            .a = {.z_m = za},
                            .b = {.z_m = zb}};
}

// The frame of a camera at latitude and longitude 0 that looks north: x is up, y east, z north.
static void ray_of(const compare_params *p, int i, double o[3], double d[3])
{
    double s = 2 * tan(p->camera.fov_deg * M_PI / 360) / H,
           pitch = p->camera.pitch_deg * M_PI / 180;
    double x = (i % W + 0.5 - W / 2.0) * s, y = (H / 2.0 - i / W - 0.5) * s;
    o[0] = RADIUS + p->camera.alt_m;
    o[1] = o[2] = 0;
    d[0] = sin(pitch) + y * cos(pitch);
    d[1] = x;
    d[2] = cos(pitch) - y * sin(pitch);
}

static double sphere_depth(const double o[3], const double d[3], double radius)
{
    double a = 0, b = 0, c = -radius * radius;
    for (int k = 0; k < 3; k++) {
        a += d[k] * d[k];
        b += o[k] * d[k];
        c += o[k] * o[k];
    }
    double q = b * b - a * c;
    return q < 0 || b > 0 ? (double)NAN : c / (-b + sqrt(q));
}

static void draw_sphere(const compare_params *p, double radius, float *z, bool normals)
{
    for (int i = 0; i < N; i++) {
        double o[3], d[3];
        ray_of(p, i, o, d);
        double t = sphere_depth(o, d, radius);
        z[i] = (float)t;
        for (int k = 0; normals && k < 3; k++) normal[k][i] = (float)((o[k] + t * d[k]) / radius);
    }
}

// Where a point appears, px from the centre.
static void project(const compare_params *p, const double at[3], double px[2])
{
    double s = 2 * tan(p->camera.fov_deg * M_PI / 360) / H,
           pitch = p->camera.pitch_deg * M_PI / 180;
    double up = at[0] - RADIUS - p->camera.alt_m;
    double ahead = up * sin(pitch) + at[2] * cos(pitch);
    px[0] = at[1] / ahead / s;
    px[1] = (up * cos(pitch) - at[2] * sin(pitch)) / ahead / s;
}

static void run(const compare_params *p, compare_result *r)
{
    maps = (compare_maps){geometric, depth, silhouette, kind};
    assert_int_equal(compare_pictures(p, &maps, r), OK);
    assert_int_equal(r->sky + r->ground + r->silhouette + r->missing + r->extra, N);
}

// A ground one metre too high, straight down and towards the horizon: each pixel's error is what
// the point one metre above appears to move, by projecting both points.
static void test_metre_too_high(void **state)
{
    (void)state;
    static const double pitches[] = {-90, -60, -30, -5};
    for (int view = 0; view < 8; view++) {
        compare_params p = params_of(1000, pitches[view / 2], view == 7 ? 5 : 70);
        compare_result r;
        draw_sphere(&p, RADIUS, zb, true);
        draw_sphere(&p, RADIUS + 1, za, false);
        if (view & 1) p.b.nx = normal[0], p.b.ny = normal[1], p.b.nz = normal[2];
        run(&p, &r);
        assert_true(r.ground > N / 4);
        for (int i = 0; i < N; i++) {
            if (kind[i] != COMPARE_GROUND) continue;
            // Neighbours say little of a normal that changes as fast as just below the limb.
            if (!(view & 1) && i >= 6 * W && isnan(zb[i - 6 * W])) continue;
            double o[3], d[3], below[3], above[3], from[2], to[2];
            ray_of(&p, i, o, d);
            double t = sphere_depth(o, d, RADIUS);
            for (int k = 0; k < 3; k++) {
                below[k] = o[k] + t * d[k];
                above[k] = below[k] * (1 + 1 / RADIUS);
            }
            project(&p, below, from);
            project(&p, above, to);
            double want = hypot(to[0] - from[0], to[1] - from[1]);
            // So far along the ray the sphere is below its tangent plane.
            double along = (za[i] - zb[i]) * sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            want *= 1 - along * along / (2 * RADIUS);
            check_near(geometric[i], want, 0.01 * fabs(want) + 2e-5);
            check_near(depth[i], za[i] - zb[i], 1e-9);
        }
        print_message("pitch %3g fov %2g: rms %.4f max %.4f px at %d,%d\n", p.camera.pitch_deg,
                      p.camera.fov_deg, r.geometric_px.rms, r.geometric_px.max, r.geometric_px.x,
                      r.geometric_px.y);
    }
}

// The numbers themselves, by hand: straight down from 1000 m a metre moves a point at x px from the
// centre by x / 1000; the largest is in the corner; a surface that faces the ray is off by 1 m /
// the pixel's size at 1000 m.
static void test_straight_down(void **state)
{
    (void)state;
    compare_params p = params_of(1000, -90, 90);
    compare_result r;
    draw_sphere(&p, RADIUS, zb, false);
    draw_sphere(&p, RADIUS + 1, za, false);
    run(&p, &r);
    check_near(r.geometric_px.max, hypot(159.5, 119.5) / 1000, 1e-3);
    check_near(r.geometric_px.median, 0.1, 0.02);
    check_near(r.distance_px.median, 1 / (1000 * 2.0 / H), 1e-3);
    check_near(r.depth_m.mean, 1, 1e-2);
    check_near(r.depth_relative.rms, 1e-3, 1e-5);
    assert_int_equal(r.silhouette + r.missing + r.extra, 0);
    assert_true(r.geometric_px.x == 0 || r.geometric_px.x == W - 1);
    assert_true(r.geometric_px.y == 0 || r.geometric_px.y == H - 1);
}

// A limb moved outwards by s pixels all around.
static void test_limb(void **state)
{
    (void)state;
    static const double moved[] = {0, 0.5, 1, 3, 6.5, -2};
    for (int k = 0; k < 6; k++) {
        compare_params p = params_of(3 * RADIUS, -88.3, 45);
        compare_result r;
        // tan of the limb's angle is R / sqrt(d^2 - R^2).
        double s = 2 * tan(22.5 * M_PI / 180) / H, d = 4 * RADIUS, limb = 1 / sqrt(15.0);
        double grown = limb + moved[k] * s, radius = d * grown / sqrt(1 + grown * grown);
        draw_sphere(&p, RADIUS, zb, false);
        draw_sphere(&p, radius, za, false);
        run(&p, &r);
        double inner = limb / s, area = M_PI * (pow(inner + moved[k], 2) - inner * inner);
        print_message("limb moved %4.1f px: mean %.3f rms %.3f 99.9 %% %.2f max %.2f, %zu edges, "
                      "%zu extra (area %.0f)\n",
                      moved[k], r.limb_px.mean, r.limb_px.rms, r.limb_px.rank_999, r.limb_px.max,
                      r.edges_b, r.extra, area);
        check_near(r.limb_px.mean, fabs(moved[k]), 0.03 * fabs(moved[k]) + 0.02);
        check_near(r.limb_px.median, fabs(moved[k]), 0.71);
        assert_true(r.limb_px.max <= fabs(moved[k]) + 1.01);
        check_near((double)r.extra - (double)r.missing, area, 0.02 * fabs(area) + 12);
        assert_int_equal(r.edges_only_a + r.edges_only_b, 0);
        assert_int_equal(r.missing_inside, 0);
        assert_int_equal(r.geometric_px.count, r.ground);
    }
}

// Ground where B has sky: an island far from its limb is outside, a pixel beside it is the limb's.
static void test_island(void **state)
{
    (void)state;
    compare_params p = params_of(3 * RADIUS, -90, 45);
    compare_result r;
    draw_sphere(&p, RADIUS, zb, false);
    memcpy(za, zb, sizeof za);
    for (int y = 4; y < 8; y++)
        for (int x = 6; x < 12; x++) za[y * W + x] = (float)(3 * RADIUS);
    int row = H / 2 * W, x = 0;
    while (isnan(zb[row + x])) x++;
    za[row + x - 1] = zb[row + x];
    run(&p, &r);
    assert_int_equal(r.extra, 4 * 6 + 1);
    assert_int_equal(r.extra_outside, 4 * 6);
    assert_int_equal(r.missing, 0);
    assert_int_equal(kind[5 * W + 7], COMPARE_EXTRA);
}

// A wall in front of another, its slanted edge moved: all of the difference is the silhouette's.
static void draw_wall(float *z, double edge, double slope, double near, double far)
{
    for (int i = 0; i < N; i++)
        z[i] = (float)(i % W + 0.5 < edge + slope * (i / W + 0.5) ? near : far);
}

static void test_wall(void **state)
{
    (void)state;
    static const double moved[] = {0.5, 1, 3, -3, 6}, slopes[] = {0.13, -0.7, 0.99};
    for (int i = 0; i < 15; i++) {
        compare_params p = params_of(10, 0, 60);
        compare_result r;
        double slope = slopes[i / 5], shift = moved[i % 5] * hypot(1, slope);
        draw_wall(zb, 150.3 - 120 * slope, slope, 500, 800);
        draw_wall(za, 150.3 - 120 * slope + shift, slope, 500, 800);
        run(&p, &r);
        print_message("slope %g moved %g: mean %.3f\n", slope, moved[i % 5], r.ridge_px.mean);
        check_near(r.ridge_px.mean, fabs(moved[i % 5]), 0.05 * fabs(moved[i % 5]));
        assert_int_equal(r.edges_only_b + r.edges_only_a, 0);
        assert_true(r.edges_b > 200);
        check_near(r.geometric_px.max, 0, 0);
        assert_true(r.geometric_all_px.max > 0 || slope == 0);
    }
}

// Farther than the search: the edge is not found, the pixels between are told as they are.
static void test_wall_too_far(void **state)
{
    (void)state;
    compare_params p = params_of(10, 0, 60);
    compare_result r;
    draw_wall(zb, 150, 0, 500, 800);
    draw_wall(za, 162, 0, 500, 800);
    run(&p, &r);
    assert_int_equal(r.edges_only_b, H);
    assert_int_equal(r.edges_only_a, H);
    assert_int_equal(r.ridge_px.count, 0);
    assert_true(isnan(r.ridge_px.max));
    assert_true(r.geometric_px.max > 10);
    assert_in_range(r.geometric_px.x, 151, 160);
}

// Slopes, creases and valleys are no silhouettes, and none of their pixels is left out.
static void test_creases(void **state)
{
    (void)state;
    for (int sense = -1; sense <= 1; sense += 2) {
        compare_params p = params_of(10, 0, 60);
        compare_result r;
        for (int i = 0; i < N; i++) {
            double x = fabs(i % W + 0.5 - 160) / W, y = (i / W + 0.5) / H;
            za[i] = zb[i] = (float)(1 / (1e-3 * (3 + 5 * sense * x + 0.9 * y)));
        }
        run(&p, &r);
        assert_int_equal(r.ground, N);
        check_near(r.geometric_px.max, 0, 0);
        assert_int_equal(r.geometric_px.count, N);
    }
}

// One bump and one hole, both where they are.
static void test_bump_and_hole(void **state)
{
    (void)state;
    compare_params p = params_of(1000, -40, 70);
    compare_result r;
    draw_sphere(&p, RADIUS, zb, true);
    memcpy(za, zb, sizeof za);
    double pixel = zb[100 * W + 200] * 2 * tan(35 * M_PI / 180) / H;
    for (int y = -20; y <= 20; y++)
        for (int x = -20; x <= 20; x++) {
            double high = 2 * pixel * exp(-(x * x + y * y) / 50.0);
            za[(100 + y) * W + 200 + x] -= (float)high;
        }
    for (int y = 180; y < 184; y++)
        for (int x = 50; x < 55; x++) za[y * W + x] = NAN;
    za[20 * W + 20] = NAN;
    double lat[N];
    for (int i = 0; i < N; i++) lat[i] = i;
    p.b.lat_deg = lat;
    run(&p, &r);
    assert_int_equal(r.missing, 21);
    assert_int_equal(r.missing_inside, 21);
    assert_int_equal(r.extra, 0);
    assert_true(r.edges_only_a >= 9);
    assert_int_equal(r.edges_b, 0);
    assert_int_equal(r.geometric_px.x, 200);
    check_near(r.geometric_px.y, 100, 1);
    check_near(r.geometric_px.lat_deg, r.geometric_px.y * W + 200, 0);
    assert_true(r.geometric_px.max > 0.5 && r.geometric_px.max < 2);
    assert_int_equal(kind[181 * W + 52], COMPARE_MISSING);
    assert_int_equal(kind[20 * W + 21], COMPARE_SILHOUETTE);
}

// A far ridge of which one row shows between a near one and the sky: where A has the near one a
// pixel lower, that is its silhouette and no error of its ground. The sky's edge counts, not this.
static void test_thin_ridge(void **state)
{
    (void)state;
    compare_params p = params_of(1000, 0, 60);
    compare_result r;
    for (int i = 0; i < N; i++) {
        za[i] = i / W < 120 ? NAN : i / W < 123 ? 9000 : 1000;
        zb[i] = i / W < 120 ? NAN : i / W < 121 ? 9000 : 1000;
    }
    run(&p, &r);
    assert_int_equal(kind[121 * W + 100], COMPARE_SILHOUETTE);
    assert_int_equal(kind[122 * W + 100], COMPARE_SILHOUETTE);
    assert_true(r.geometric_px.max < 1e-6);
    assert_int_equal(r.edges_b, W);
    assert_true(r.limb_px.max == 0);
}

// A peak whose top is gone is a silhouette too low; a slit or a hole beside it is not. The top is a
// triangle, a row wider than 2 px at each step down.
static void test_summits(void **state)
{
    (void)state;
    enum { PEAK_X = 160, PEAK_ROWS = 30, LOST_ROWS = 5 };
    compare_params p = params_of(1000, 0, 60);
    compare_result r;
    for (int i = 0; i < N; i++) zb[i] = i / W < 120 ? NAN : 1000;
    for (int j = 0; j < PEAK_ROWS; j++)
        for (int x = PEAK_X - j; x <= PEAK_X + j; x++) zb[(120 - PEAK_ROWS + j) * W + x] = 1000;
    memcpy(za, zb, sizeof za);
    for (int j = 0; j < LOST_ROWS; j++)
        for (int x = PEAK_X - j; x <= PEAK_X + j; x++) za[(120 - PEAK_ROWS + j) * W + x] = NAN;
    run(&p, &r);
    assert_int_equal(r.missing, LOST_ROWS * LOST_ROWS);
    assert_int_equal(r.missing_inside, 0);
    assert_true(r.limb_px.max >= LOST_ROWS - 1);
    // A slit of a pixel, two deep below that, is a slit from its second pixel on.
    for (int y = 95; y < 97; y++) za[y * W + PEAK_X] = NAN;
    run(&p, &r);
    assert_int_equal(r.missing_inside, 1);
    for (int y = 95; y < 97; y++) za[y * W + PEAK_X] = 1000;
    // A slit of a pixel, six deep from the plain's limb: its top and what is next to that touches
    // sky of B.
    for (int y = 120; y < 126; y++) za[y * W + 60] = NAN;
    run(&p, &r);
    assert_int_equal(r.missing_inside, 6 - 1);
    // Four pixels under the flank, ground of A all around.
    for (int y = 124; y < 126; y++)
        for (int x = 220; x < 222; x++) za[y * W + x] = NAN;
    run(&p, &r);
    assert_int_equal(r.missing_inside, 6 - 1 + 4);
    // A silhouette ten pixels too low is more than is looked for.
    for (int i = 0; i < N; i++) {
        zb[i] = i / W < 120 ? NAN : 1000;
        za[i] = i / W < 130 ? NAN : 1000;
    }
    run(&p, &r);
    assert_int_equal(r.missing_inside, 2 * W);
}

static float light_of(double code)
{
    return (float)(code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4));
}

static void test_color(void **state)
{
    (void)state;
    compare_params p = params_of(1000, -90, 60);
    compare_result r;
    draw_sphere(&p, RADIUS, zb, false);
    memcpy(za, zb, sizeof za);
    run(&p, &r);
    assert_int_equal(r.colors, 0);
    assert_true(isnan(r.psnr_db));
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < N; i++) {
            color_a[k][i] = light_of((i % 200 + 1) / 255.0);
            color_b[k][i] = light_of((i % 200 + (k == 1 ? 3 : 1)) / 255.0);
        }
    p.a.r = color_a[0], p.a.g = color_a[1], p.a.b = color_a[2];
    p.b.r = color_b[0], p.b.g = color_b[1], p.b.b = color_b[2];
    run(&p, &r);
    assert_int_equal(r.colors, N);
    check_near(r.psnr_db, 20 * log10(255 / 2.0) + 10 * log10(3), 1e-3);
    p.b = p.a;
    run(&p, &r);
    assert_true(isinf(r.psnr_db) && r.psnr_db > 0);
}

static void test_statistics(void **state)
{
    (void)state;
    compare_params p = params_of(1000, -90, 60);
    compare_result r;
    for (int i = 0; i < N; i++) {
        zb[i] = 1000;
        za[i] = 1000 + (float)((i * 7919LL) % N) * 1e-3F; // each of 0 .. N - 1 once
    }
    run(&p, &r);
    assert_int_equal(r.depth_m.count + r.silhouette, N);
    for (int i = 0; i < N; i++) za[i] = 1000 + (i / W) * 0.001F;
    run(&p, &r);
    assert_int_equal(r.depth_m.count, N);
    check_near(r.depth_m.median, (H / 2 - 1) * 0.001, 1e-4);
    check_near(r.depth_m.max, (H - 1) * 0.001, 1e-4);
    check_near(r.depth_m.rank_999, (H - 1) * 0.001, 1e-4);
    check_near(r.depth_m.mean, (H - 1) * 0.0005, 1e-4);
    check_near(r.depth_m.rms, 0.001 * sqrt((H - 1) * (2.0 * H - 1) / 6), 1e-4);
    assert_int_equal(r.depth_m.y, H - 1);
}

struct terrain {
    float z[N], normals[3][N], height[N];
    double lat[N], lon[N];
};

static void render(const opened *planet, reference_camera c, struct terrain *t)
{
    reference_params q = {
        .pyramid = planet->pyramid, .camera = c, .width = W, .height = H, .zoom = -1, .threads = 2};
    reference_planes planes = {.z_m = t->z,
                               .height_m = t->height,
                               .lat_deg = t->lat,
                               .lon_deg = t->lon,
                               .nx = t->normals[0],
                               .ny = t->normals[1],
                               .nz = t->normals[2]};
    assert_int_equal(reference_render(&q, &planes), OK);
}

// Normals of the field are square to the ground between neighbouring hits of a very narrow view.
static void check_normals(const opened *planet, geo_ellipsoid e, reference_camera c)
{
    static struct terrain t;
    c.fov_deg = 1;
    render(planet, c, &t);
    int bad = 0, seen = 0;
    for (int i = 0; i < N - W; i++) {
        if (i % W == W - 1 || isnan(t.z[i]) || isnan(t.z[i + 1]) || isnan(t.z[i + W])) continue;
        double at[3][3], n[3];
        const int where[3] = {i, i + 1, i + W};
        for (int k = 0; k < 3; k++)
            reference_ecef(e.a, e.b, t.lat[where[k]], t.lon[where[k]], t.height[where[k]], at[k]);
        dvec3 a = {at[1][0] - at[0][0], at[1][1] - at[0][1], at[1][2] - at[0][2]},
              b = {at[2][0] - at[0][0], at[2][1] - at[0][1], at[2][2] - at[0][2]};
        for (int k = 0; k < 3; k++) n[k] = t.normals[k][i];
        dvec3 m = {n[0], n[1], n[2]};
        check_near(dvec3_length(m), 1, 1e-6);
        seen++;
        bad += fabs(dvec3_dot(m, a)) > 2e-3 * dvec3_length(a) ||
               fabs(dvec3_dot(m, b)) > 2e-3 * dvec3_length(b);
    }
    if (bad * 20 > seen || seen < N / 2) fail_msg("%d of %d normals are not square", bad, seen);
}

// Mountains of a few samples' width, up to 4 km high.
static float mountains(tile_id id, int row, int col, double lat, double lon)
{
    (void)id, (void)row, (void)col;
    double u = cos(lat) * cos(lon), v = cos(lat) * sin(lon), w = sin(lat), h = 1000;
    for (int k = 0; k < 5; k++) {
        double f = 60.0 * (1 << k);
        h += 3500.0 / (2 << k) * sin(f * u + 1.3 * k) * sin(f * v + 0.7) * cos(f * w - k);
        h += 2500.0 / (2 << k) * sin(f * (v - w) - 2.1 * k);
    }
    return (float)h;
}

static void test_turned_by_half_a_pixel(void **state)
{
    (void)state;
    static struct terrain a, b;
    static const reference_camera cameras[] = {{40, 20, 9000, 30, -12, 0, 60},
                                               {-10, 179.9, 12000, 200, -35, 10, 90},
                                               {89.9, 0, 20000, 0, -8, 0, 50},
                                               {20, 10, 3e6, 0, -70, 0, 60},
                                               {20, 10, 6000, 0, -3, 0, 40}};
    fixture files;
    fixture_init(&files, "reference-compare");
    fixture_write(&files, 3, 0, mountains, NULL);
    opened planet = fixture_open(&files, 0, false);
    geo_ellipsoid e = pyramid_meta(planet.pyramid)->ellipsoid;
    for (int i = 0; i < 5; i++) {
        reference_camera c = cameras[i], turned = c;
        double half = atan(0.5 * 2 * tan(c.fov_deg * M_PI / 360) / H) * 180 / M_PI;
        turned.pitch_deg += half;
        render(&planet, c, &b);
        render(&planet, turned, &a);
        compare_params p = {e, c, W, H, {.z_m = a.z}, {.z_m = b.z}};
        p.b.nx = b.normals[0], p.b.ny = b.normals[1], p.b.nz = b.normals[2];
        compare_result r;
        run(&p, &r);
        double edge = tan(c.fov_deg * M_PI / 360);
        double most = 0.5 * (1 + edge * edge * (1 + (double)W * W / H / H));
        print_message(
            "%g,%g %g m: rms %.3f median %.3f 99.9 %% %.3f max %.3f (bound %.3f) px, "
            "ground %zu silhouette %zu missing %zu extra %zu; all: 99.9 %% %.3f max %.3f; "
            "limb: mean %.3f, ridges: mean %.3f rms %.3f max %.2f of %zu, only b %zu, only a %zu "
            "of %zu\n",
            c.lat_deg, c.lon_deg, c.alt_m, r.geometric_px.rms, r.geometric_px.median,
            r.geometric_px.rank_999, r.geometric_px.max, most, r.ground, r.silhouette, r.missing,
            r.extra, r.geometric_all_px.rank_999, r.geometric_all_px.max, r.limb_px.mean,
            r.ridge_px.mean, r.ridge_px.rms, r.ridge_px.max, r.edges_b, r.edges_only_b,
            r.edges_only_a, r.edges_a);
        assert_true(r.ground > N / 3);
        assert_true(r.geometric_px.rank_999 <= 1.06 * most);
        assert_true(r.geometric_px.max <= 2.5);
        assert_in_range(r.limb_px.mean * 1000, 250, 750);
        assert_true(16 * (r.edges_only_a + r.edges_only_b) <= r.edges_a + r.edges_b);
        check_normals(&planet, e, c);
    }
    fixture_close(&planet);
    fixture_deinit(&files);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_metre_too_high),
        cmocka_unit_test(test_straight_down),
        cmocka_unit_test(test_limb),
        cmocka_unit_test(test_island),
        cmocka_unit_test(test_wall),
        cmocka_unit_test(test_wall_too_far),
        cmocka_unit_test(test_creases),
        cmocka_unit_test(test_bump_and_hole),
        cmocka_unit_test(test_summits),
        cmocka_unit_test(test_thin_ridge),
        cmocka_unit_test(test_color),
        cmocka_unit_test(test_statistics),
        cmocka_unit_test(test_turned_by_half_a_pixel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
