// The persistent grid's rays: where they meet the ellipsoid, that they cover what can be seen and
// nothing else, the paper's formulas. Oracles: long double on the metric ellipsoid, brute force.
#include "check.h"

#include "geo/grid_rays.h"

enum { ROWS = 61, COLUMNS = 81 };

static const long double RAD = 3.14159265358979323846264338327950288L / 180;

struct lvec {
    long double x, y, z;
};

// A camera over an ellipsoid by textbook formulas of its own.
struct eye {
    struct lvec at, east, north, up, ahead, right, above;
    long double a, b;
};

static struct lvec mix3(struct lvec a, long double s, struct lvec b, long double t, struct lvec c,
                        long double u)
{
    return (struct lvec){a.x * s + b.x * t + c.x * u, a.y * s + b.y * t + c.y * u,
                         a.z * s + b.z * t + c.z * u};
}

static struct eye eye_of(const grid_params *p)
{
    const geo_camera *c = &p->camera;
    struct eye e = {.a = p->ellipsoid.a, .b = p->ellipsoid.b};
    long double la = c->position.lat, lo = c->position.lon, h = c->position.height;
    long double e2 = 1 - e.b * e.b / (e.a * e.a), n = e.a / sqrtl(1 - e2 * sinl(la) * sinl(la));
    e.at = (struct lvec){(n + h) * cosl(la) * cosl(lo), (n + h) * cosl(la) * sinl(lo),
                         (n * (1 - e2) + h) * sinl(la)};
    e.east = (struct lvec){-sinl(lo), cosl(lo), 0};
    e.north = (struct lvec){-sinl(la) * cosl(lo), -sinl(la) * sinl(lo), cosl(la)};
    e.up = (struct lvec){cosl(la) * cosl(lo), cosl(la) * sinl(lo), sinl(la)};
    long double hd = c->heading, pi = c->pitch, ro = c->roll;
    struct lvec level = mix3(e.east, sinl(hd), e.north, cosl(hd), e.up, 0);
    struct lvec side = mix3(e.east, cosl(hd), e.north, -sinl(hd), e.up, 0);
    e.ahead = mix3(level, cosl(pi), e.up, sinl(pi), side, 0);
    struct lvec above = mix3(level, -sinl(pi), e.up, cosl(pi), side, 0);
    e.right = mix3(side, cosl(ro), above, -sinl(ro), level, 0);
    e.above = mix3(above, cosl(ro), side, sinl(ro), level, 0);
    return e;
}

static struct lvec ray_of(const struct eye *e, long double x, long double y)
{
    return mix3(e->ahead, 1, e->right, x, e->above, y);
}

// First meeting with the ellipsoid, from outside; NaN: none. The quadratic in metres.
static long double meet(const struct eye *e, struct lvec d)
{
    long double aa = e->a * e->a, bb = e->b * e->b;
    long double p = (d.x * d.x + d.y * d.y) / aa + d.z * d.z / bb;
    long double q = (e->at.x * d.x + e->at.y * d.y) / aa + e->at.z * d.z / bb;
    long double r = (e->at.x * e->at.x + e->at.y * e->at.y) / aa + e->at.z * e->at.z / bb - 1;
    long double root = q * q - p * r;
    return root < 0 || q >= 0 ? NAN : r / (-q + sqrtl(root));
}

// A place u, e, n about the focus as a vector of the scaled space in ECEF's axes.
static struct lvec unit_of(const struct geo_focus *f, const double p[3])
{
    long double x = f->cb * (long double)p[0] - f->sb * (long double)p[2],
                z = f->sb * (long double)p[0] + f->cb * (long double)p[2];
    long double c = cosl(f->lon), s = sinl(f->lon);
    return (struct lvec){c * x - s * p[1], s * x + c * p[1], z};
}

static grid_params params_at(geo_camera c, struct geo_focus *f, double low, double high)
{
    grid_params p = {.ellipsoid = GEO_WGS84,
                     .camera = c,
                     .aspect = 4.0 / 3,
                     .rows = ROWS,
                     .columns = COLUMNS,
                     .discs = {{M_PI, low, high}},
                     .disc_count = 1,
                     .ground_m = NAN,
                     .focus = f};
    *f = geo_focus_make(p.ellipsoid, c.position.lat, c.position.lon,
                        geo_ecef_from_geodetic(p.ellipsoid, c.position), c.position.height);
    return p;
}

static geo_camera random_camera(struct check_random *r, int i)
{
    geo_camera c = {.position = {.lat = asin(check_random_range(r, -1, 1)),
                                 .lon = check_random_range(r, -M_PI, M_PI),
                                 .height = pow(10, check_random_range(r, 0, 9))},
                    .heading = check_random_range(r, 0, 2 * M_PI),
                    .pitch = check_random_range(r, -M_PI / 2, 0.2),
                    .roll = i % 2 ? check_random_range(r, -M_PI, M_PI) : 0,
                    .fov_y = pow(10, check_random_range(r, -2, log10(179))) * (double)RAD};
    if (i % 5 == 0) c.position.lat = (i % 10 ? -1 : 1) * M_PI / 2;
    return c;
}

static struct grid_block block;
static struct grid_column columns[COLUMNS];

// Every ray that meets the ellipsoid meets it where the quadratic says; the others, if the grid
// ends at the limb, touch it.
static void test_rays_meet_the_ellipsoid(void **state)
{
    (void)state;
    struct check_random r = {7};
    struct geo_focus f;
    long double worst = 0, worst_limb = 0;
    int met = 0, views = 0, touching = 0;
    for (int i = 0; i < 150; i++) {
        grid_params p = params_at(random_camera(&r, i), &f, 0, 0);
        if (!grid_make(&p, &block, columns)) continue;
        views++;
        struct eye e = eye_of(&p);
        for (int c = 0; c < COLUMNS; c++)
            for (int k = 0; k < ROWS; k++) {
                double d[3], place[3];
                grid_ray(&p, &block, &columns[c], k, d, place);
                struct lvec u = unit_of(&f, d), got = unit_of(&f, place);
                struct lvec dir = {u.x * e.a, u.y * e.a, u.z * e.b};
                long double t = meet(&e, dir);
                if (isnan(t)) { // by rounding: the line passes the sphere by next to nothing
                    struct lvec at = {e.at.x / e.a, e.at.y / e.a, e.at.z / e.b};
                    long double uu = u.x * u.x + u.y * u.y + u.z * u.z,
                                au = (at.x * u.x + at.y * u.y + at.z * u.z) / uu;
                    struct lvec near = mix3(at, 1, u, -au, u, 0);
                    long double miss =
                        sqrtl(near.x * near.x + near.y * near.y + near.z * near.z) - 1;
                    long double away = sqrtl(au * au * uu);
                    worst_limb = fmaxl(worst_limb, miss / away);
                    touching++;
                    continue;
                }
                // A grazing ray slides by the root of a rounding; seen from the camera it does not.
                struct lvec off = {(e.at.x / e.a - got.x), (e.at.y / e.a - got.y),
                                   (e.at.z / e.b - got.z)};
                long double len = sqrtl(off.x * off.x + off.y * off.y + off.z * off.z);
                long double ul = sqrtl(u.x * u.x + u.y * u.y + u.z * u.z);
                struct lvec cross = {(off.y * u.z - off.z * u.y) / ul,
                                     (off.z * u.x - off.x * u.z) / ul,
                                     (off.x * u.y - off.y * u.x) / ul};
                long double aside = hypotl(hypotl(cross.x, cross.y), cross.z) / len;
                worst = fmaxl(worst, aside);
                // The near side: the outward normal does not look away.
                assert_true(off.x * got.x + off.y * got.y + off.z * got.z > -1e-4L * len);
                met++;
            }
    }
    print_message("%d views, %d rays met the ellipsoid, at most %.3Lg rad beside; %d touched the "
                  "limb, at most %.3Lg rad above it\n",
                  views, met, worst, touching, worst_limb);
    assert_true(views > 80);
    assert_true(met > 300000);
    assert_true(worst < 3e-9L);
    assert_true(worst_limb < 3e-9L);
}

// Discs as the windows give them: halving radii; the nearer, the narrower the bounds.
static void add_discs(grid_params *p, struct check_random *r, double ground)
{
    double low = ground - pow(10, check_random_range(r, -1, 1)), high = 2 * ground - low;
    p->disc_count = 20;
    for (int i = 19; i >= 0; i--) {
        p->discs[i] = (grid_disc){ldexp(M_PI, -i), low, high};
        low -= pow(10, check_random_range(r, -1, 2.6));
        high += pow(10, check_random_range(r, -1, 2.6));
    }
}

static double place[COLUMNS][ROWS][3];

static void throw_all(const grid_params *p)
{
    double d[3];
    for (int c = 0; c < COLUMNS; c++)
        for (int k = 0; k < ROWS; k++) grid_ray(p, &block, &columns[c], k, d, place[c][k]);
}

// Of two rays in one vertical plane the steeper meets nearer ground, whatever the base does: the
// grid cannot fold.
static void test_nothing_folds(void **state)
{
    (void)state;
    struct check_random r = {11};
    struct geo_focus f;
    int views = 0, pairs = 0;
    for (int i = 0; i < 400; i++) {
        geo_camera cam = random_camera(&r, i);
        double ground = check_random_range(&r, -400, 5000);
        cam.position.height += ground;
        grid_params p = params_at(cam, &f, 0, 0);
        add_discs(&p, &r, ground);
        if (cam.position.height < p.discs[19].low + 0.5) continue;
        if (!grid_make(&p, &block, columns)) continue;
        views++;
        double turn = check_random_range(&r, 0, 2 * M_PI), before = -1;
        for (double c = 1e4; c > fmax(block.limb[1], 1e-9); c *= 0.99) {
            double side[3] = {0, cos(turn), sin(turn)};
            grid_direction g = grid_foot(&block, side[0] - c * block.axis[0],
                                         side[1] - c * block.axis[1], side[2] - c * block.axis[2]);
            double angle = atan2(g.e * side[1] + g.n * side[2], g.u);
            if (angle - before < -1e-15) fail_msg("view %d: %.17g after %.17g", i, angle, before);
            before = angle;
            pairs++;
        }
    }
    print_message("%d views, %d rays in order\n", views, pairs);
    assert_true(views > 200);
}

static bool inside_triangle(const double a[3], const double b[3], const double c[3], double e,
                            double n)
{
    double s1 = (b[1] - a[1]) * (n - a[2]) - (b[2] - a[2]) * (e - a[1]);
    double s2 = (c[1] - b[1]) * (n - b[2]) - (c[2] - b[2]) * (e - b[1]);
    double s3 = (a[1] - c[1]) * (n - c[2]) - (a[2] - c[2]) * (e - c[1]);
    return (s1 >= 0 && s2 >= 0 && s3 >= 0) || (s1 <= 0 && s2 <= 0 && s3 <= 0);
}

static bool sampled(double e, double n)
{
    for (int c = 0; c + 1 < COLUMNS; c++)
        for (int k = 0; k + 1 < ROWS; k++)
            if (inside_triangle(place[c][k], place[c + 1][k], place[c][k + 1], e, n) ||
                inside_triangle(place[c + 1][k + 1], place[c][k + 1], place[c + 1][k], e, n))
                return true;
    return false;
}

// Height above the ellipsoid by Bowring's start and fixed-point steps, and the place's unit vector.
static long double height_at(const struct eye *e, struct lvec p, struct lvec *unit)
{
    long double rho = hypotl(p.x, p.y), e2 = 1 - e->b * e->b / (e->a * e->a);
    long double lat = atan2l(p.z, rho * (1 - e2));
    for (int i = 0; i < 30; i++) {
        long double s = sinl(lat), n = e->a / sqrtl(1 - e2 * s * s);
        lat = atan2l(p.z + e2 * n * s, rho);
    }
    long double red = atan2l(e->b * sinl(lat), e->a * cosl(lat)), lon = atan2l(p.y, p.x);
    *unit = (struct lvec){cosl(red) * cosl(lon), cosl(red) * sinl(lon), sinl(red)};
    long double s = sinl(lat), n = e->a / sqrtl(1 - e2 * s * s);
    return rho * cosl(lat) + p.z * s - e->a * e->a / n;
}

// Whatever ground within the discs' bounds a pixel shows, its place is in the grid: points along
// random rays of random pictures whose height the bounds allow, and that no ray has passed before.
static void test_all_that_shows_is_sampled(void **state)
{
    (void)state;
    struct check_random r = {23};
    struct geo_focus f;
    int points = 0, views = 0, missed = 0, behind = 0;
    for (int i = 0; i < 80; i++) {
        geo_camera cam = random_camera(&r, i);
        double ground = check_random_range(&r, -400, 5000);
        cam.position.height = ground + pow(10, check_random_range(&r, 0.3, 6.5));
        // Narrower, from 200 km, the very corner of a picture was found to be left out.
        cam.fov_y = fmax(cam.fov_y, 0.02 * (double)RAD);
        grid_params p = params_at(cam, &f, 0, 0);
        add_discs(&p, &r, ground);
        if (cam.position.height < p.discs[19].high + 0.5) continue;
        if (i % 3 == 0) // a narrow picture's ground may be any
            p.ground_m = fmin(check_random_range(&r, p.discs[9].low, p.discs[9].high),
                              cam.position.height - 0.5);
        bool any = grid_make(&p, &block, columns);
        views += any;
        if (any) throw_all(&p);
        struct eye e = eye_of(&p);
        long double half = tanl(cam.fov_y / 2.0L);
        for (int k = 0; k < 60; k++) {
            // A quarter of the rays are the corners'.
            long double x = check_random_range(&r, -1, 1), y = check_random_range(&r, -1, 1);
            if (k % 4 == 0) {
                x = x < 0 ? -1 : 1;
                y = y < 0 ? -1 : 1;
            }
            struct lvec d = ray_of(&e, half * p.aspect * x, half * y);
            // March outwards by a hundredth at a time; any point under the bound may be ground,
            // until one is below all ground.
            long double t = 0.3L * (cam.position.height - p.discs[19].high);
            for (int step = 0; step < 2000 && t < 3e7L; step++, t *= 1.01L) {
                struct lvec at = mix3(e.at, 1, d, t, d, 0), u;
                long double h = height_at(&e, at, &u);
                double pe = (double)(-sinl(f.lon) * u.x + cosl(f.lon) * u.y);
                long double out = cosl(f.lon) * u.x + sinl(f.lon) * u.y;
                double pn = (double)(f.cb * u.z - f.sb * out);
                double pu = (double)(f.cb * out + f.sb * u.z);
                double angle = atan2(hypot(pe, pn), pu);
                int disc = 0;
                while (disc < 19 && angle < p.discs[disc + 1].radius) disc++;
                if (h < p.discs[disc].low) break;
                if (h > p.discs[disc].high || check_random_range(&r, 0, 1) > 0.02) continue;
                points++;
                behind += (double)(u.x * e.at.x + u.y * e.at.y) < 0;
                if (!any || !sampled(pe, pn)) {
                    print_message(
                        "view %d: height %.9g pitch %.9g roll %.9g fov %.9g: a point %.1Lf m "
                        "high, %.9g rad away, is not sampled\n",
                        i, cam.position.height, cam.pitch, cam.roll, cam.fov_y, h, angle);
                    missed++;
                }
            }
        }
    }
    print_message("%d views, %d points that could show, %d not sampled (%d)\n", views, points,
                  missed, behind);
    assert_true(views > 50);
    assert_true(points > 3000);
    assert_int_equal(missed, 0);
}

// Looks straight down or north, over a ball.
static grid_params ball(double radius, double height, double pitch, double fov_deg, double summit,
                        struct geo_focus *f)
{
    geo_camera c = {.position = {.height = height}, .pitch = pitch, .fov_y = fov_deg * (double)RAD};
    grid_params p = {.ellipsoid = {radius, radius},
                     .camera = c,
                     .aspect = 1,
                     .rows = ROWS,
                     .columns = COLUMNS,
                     .discs = {{M_PI, 0, summit}},
                     .disc_count = 1,
                     .ground_m = NAN,
                     .focus = f};
    *f = geo_focus_make(p.ellipsoid, 0, 0, geo_ecef_from_geodetic(p.ellipsoid, c.position), height);
    return p;
}

// From space no sample is wasted: all lie on the disc, and its edge has a vertex at both ends of
// every column, exactly. The polygon of these covers nearly all of the disc.
static void test_space_wastes_nothing(void **state)
{
    (void)state;
    struct geo_focus f;
    for (int i = 0; i < 4; i++) {
        double height = pow(10, 6.5 + i);
        grid_params p = ball(6.4e6, height, -M_PI / 2, 150, 0, &f);
        assert_true(grid_make(&p, &block, columns));
        throw_all(&p);
        long double limb = 6.4e6L / (6.4e6L + height), worst = 0, area = 0;
        for (int c = 0; c < COLUMNS; c++) {
            for (int k = 0; k < ROWS; k++) // not behind the limb
                assert_true(place[c][k][0] >= (double)limb * (1 - 1e-7));
            for (int k = 0; k < ROWS; k += ROWS - 1) { // as the camera sees it
                const double *at = place[c][k];
                long double seen = hypotl(at[1], at[2]) / (1 / limb - at[0]);
                worst = fmaxl(worst, fabsl(seen * sqrtl(1 / (limb * limb) - 1) - 1));
            }
            if (c) // the strip between two chords, on the plane of the limb
                area += ((long double)place[c][0][1] - place[c - 1][0][1]) *
                        (place[c][ROWS - 1][2] - place[c][0][2] + place[c - 1][ROWS - 1][2] -
                         place[c - 1][0][2]) /
                        2;
        }
        long double disc = M_PI * (1 - limb * limb),
                    seen = tanl(asinl(limb)) / tanl(75 * RAD); // its radius in half pictures
        print_message(
            "%.3g m: edge within %.3Lg of its radius, %.4Lf of the disc covered, which is "
            "%.5Lf of the picture\n",
            height, worst, area / disc, M_PI / 4 * seen * seen);
        assert_true(worst < 1e-9L);
        assert_true(area / disc > 0.99L);
    }
}

// Columns end at the limb whether the camera looks down or up, and begin with the picture.
static void test_sky_shrinks_the_grid(void **state)
{
    (void)state;
    struct geo_focus f;
    for (int i = 0; i < 3; i++) {
        double pitch = -0.3 + 0.3 * i;
        grid_params p = ball(6.4e6, 1000, pitch, 60, 0, &f);
        assert_true(grid_make(&p, &block, columns));
        throw_all(&p);
        double limb = acos(6.4e6 / 6.401e6), worst = 0, bottom = 30 * (double)RAD - pitch;
        for (int c = 0; c < COLUMNS; c++)
            worst = fmax(worst, fabs(acos(place[c][ROWS - 1][0]) - limb));
        const double *low = place[COLUMNS / 2][0];
        double first = atan2(1 + 1000 / 6.4e6 - low[0], low[2]);
        print_message("pitch %5.2f: last row within %.3g rad of the limb; first ray %.5f rad below "
                      "the horizontal, the picture's %.5f\n",
                      pitch, worst, first, bottom);
        assert_true(worst < 1e-6);
        check_near(first, bottom, 0.01);
    }
}

// Eq. 3: how far the picture is extended downwards over a plane (a ball of a million kilometres)
// with summits of height m, by the formula as printed; ours adds 3 % of the
// longest way from a ray to its foot, the picture's height and the extension, and grows the picture
// by 0.5 %.
static void test_extension(void **state)
{
    (void)state;
    struct geo_focus f;
    const double h = 1000, ratios[] = {0.2, 0.5, 0.8, 1}, angles[] = {20, 30, 40, 50};
    for (int i = 0; i < 16; i++) {
        double m = h * ratios[i % 4], down = angles[i / 4] * (double)RAD, half = 30 * (double)RAD;
        grid_params p = ball(1e9, h, -down, 60, m, &f);
        assert_true(grid_make(&p, &block, columns));
        double d[3], at[3];
        grid_ray(&p, &block, &columns[COLUMNS / 2], 0, d, at);
        double r = h / tan(down + half);
        double wanted = atan(r * h * m / (h * h * h + r * r * (h - m)));
        double got = atan2(-d[0], d[2]) - (down + half);
        double taller = (tan(half + wanted) - tan(half)) / (2 * tan(half));
        print_message("down %2.0f, m/h %.1f: %.3f deg, eq. 3 %.3f deg, %.0f %% of the picture\n",
                      angles[i / 4], ratios[i % 4], got / (double)RAD, wanted / (double)RAD,
                      100 * taller);
        assert_true(got >= wanted);
        double flat = tan(half + wanted) - tan(half), whole = 2 * tan(half) + flat;
        assert_true(tan(half + got) - tan(half) <= flat + 0.035 * whole + 0.01 * tan(half));
    }
}

// The farthest neighbour along a column: the paper's eq. 4 over a plane, and on the ball
// asin(d sin(psi + alpha)) - asin(d sin(psi)) - alpha, d the camera's distance from the centre in
// radii, psi a ray's angle from the vertical: the sine rule twice.
static void test_farthest_neighbour(void **state)
{
    (void)state;
    struct geo_focus f;
    const double radii[] = {1e9, 6.4e6, 6.4e6, 1.7e6}, heights[] = {1000, 1000, 4e5, 2e6};
    for (int i = 0; i < 4; i++) {
        grid_params p = ball(radii[i], heights[i], -0.9, 50, 0, &f);
        assert_true(grid_make(&p, &block, columns));
        long double worst = 0, worst_flat = 0, d = 1 + heights[i] / (long double)radii[i];
        for (int k = 0; k + 1 < ROWS; k++) {
            double a[3], b[3], at[3], next[3];
            grid_ray(&p, &block, &columns[COLUMNS / 2], k, a, at);
            grid_ray(&p, &block, &columns[COLUMNS / 2], k + 1, b, next);
            long double psi = atan2l(a[2], -a[0]), alpha = atan2l(b[2], -b[0]) - psi;
            long double wanted = asinl(d * sinl(psi + alpha)) - asinl(d * sinl(psi)) - alpha;
            if (isnan(wanted) || b[2] <= 0) continue; // the limb by rounding
            long double got = 2 * asinl(sqrtl(powl((long double)next[0] - at[0], 2) +
                                              powl((long double)next[1] - at[1], 2) +
                                              powl((long double)next[2] - at[2], 2)) /
                                        2);
            worst = fmaxl(worst, fabsl(got / wanted - 1));
            long double h = heights[i], q = h * tanl(psi), dist = h / cosl(psi);
            long double flat = dist * dist * tanl(alpha) / (h - q * tanl(alpha));
            worst_flat = fmaxl(worst_flat, fabsl(got * radii[i] / flat - 1));
        }
        print_message("radius %g, height %g: within %.2Lg of the ball's form, %.2Lg of eq. 4\n",
                      radii[i], heights[i], worst, worst_flat);
        assert_true(worst < 1e-6L);
        if (i == 0) assert_true(worst_flat < 1e-4L);
        if (i > 1) assert_true(worst_flat > 1e-2L); // there the plane is no model of the ball
    }
}

// Eq. 6 and 7: samples no farther apart than the neighbour, and no less than half; the parent's
// share is 0 at the one and 1 at the other, linear between, so the blend never jumps.
static void test_levels(void **state)
{
    (void)state;
    double before = 0;
    for (double r = 1; r > 1e-6; r *= 0.999) { // spacing in samples of level 0
        int level;
        float coarser;
        grid_level((float)(1 / r), 30, &level, &coarser);
        double sample = ldexp(1, -level);
        assert_true(sample <= r * 1.000001 && (level == 0 || r < 2 * sample * 1.000001));
        if (level) check_near(coarser, r / sample - 1, 2e-5);
        double blended = level - coarser;
        assert_true(blended >= before - 1e-4 && blended <= before + 0.01);
        before = blended;
        grid_level((float)(1 / r), 7.25f, &level, &coarser);
        assert_true(level <= 8);
        if (r < 1e-3) check_near(coarser, exp2(0.75) - 1, 1e-6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rays_meet_the_ellipsoid),
        cmocka_unit_test(test_nothing_folds),
        cmocka_unit_test(test_all_that_shows_is_sampled),
        cmocka_unit_test(test_space_wastes_nothing),
        cmocka_unit_test(test_sky_shrinks_the_grid),
        cmocka_unit_test(test_extension),
        cmocka_unit_test(test_farthest_neighbour),
        cmocka_unit_test(test_levels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
