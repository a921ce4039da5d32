#include "geo/ring_truth.h"

#include <math.h>

void ring_truth_focus(const struct truth_focus *f, exact u[3])
{
    u[0] = sinl(f->colatitude);
    u[1] = 0;
    u[2] = f->hemisphere * cosl(f->colatitude);
}

static exact geodetic_latitude(geo_ellipsoid e, exact sine, exact cosine)
{
    return atan2l((exact)e.a * sine, (exact)e.b * cosine);
}

// From a unit vector seen from the focus.
static struct ring_truth from_local(const struct truth_focus *f, exact north, exact east, exact up)
{
    exact v[3];
    ring_truth_focus(f, v);
    struct ring_truth t = {.u = {v[0] * up - v[2] * north, east, v[2] * up + v[0] * north}};
    t.rho = hypotl(t.u[0], t.u[1]);
    t.dlon = atan2l(t.u[1], t.u[0]);
    t.dlat = geodetic_latitude(f->ellipsoid, t.u[2], t.rho) -
             geodetic_latitude(f->ellipsoid, v[2], v[0]);
    return t;
}

struct ring_truth ring_truth_ideal(const struct truth_focus *f, const ring_params *p, int ring,
                                   int column)
{
    int n = p->azimuth_steps, west = column > n / 2, k = west ? column - 1 : column;
    exact t = PI_EXACT * exp2l(-(exact)ring / p->rings_per_level);
    exact azimuth = 2 * PI_EXACT * k / n;
    exact north = sinl(t) * cosl(azimuth), east = sinl(t) * sinl(azimuth);
    if (2 * k % n == 0) east = west ? -0.0L : 0.0L;
    if (4 * k == n || 4 * k == 3 * n) north = 0;
    return from_local(f, north, east, cosl(t));
}

struct ring_truth ring_truth_stored(const struct truth_focus *f, const float nev[3])
{
    exact north = nev[0], east = nev[1], up = 1 - (exact)nev[2];
    exact length = sqrtl(north * north + east * east + up * up);
    return from_local(f, north / length, east / length, up / length);
}

void ring_truth_point(geo_ellipsoid e, const exact u[3], exact h, exact p[3])
{
    const exact axis[3] = {e.a, e.a, e.b};
    exact normal[3];
    for (int i = 0; i < 3; i++) normal[i] = u[i] / axis[i];
    exact length = hypotl(hypotl(normal[0], normal[1]), normal[2]);
    for (int i = 0; i < 3; i++) p[i] = axis[i] * u[i] + h * normal[i] / length;
}

void ring_truth_tangent(const struct truth_focus *f, const exact p[3], exact out[3])
{
    exact u[3];
    ring_truth_focus(f, u);
    exact x = u[0] / f->ellipsoid.a, z = u[2] / f->ellipsoid.b, length = hypotl(x, z);
    exact cosine = x / length, sine = z / length;
    out[0] = cosine * p[0] + sine * p[2];
    out[1] = p[1];
    out[2] = cosine * p[2] - sine * p[0];
}

bool ring_truth_has_longitude(const struct ring_truth *t, int level)
{
    return t->rho > 1e-6L * exp2l(-level);
}

exact ring_truth_lat_texel(int level)
{
    return 2 * PI_EXACT * exp2l(-level) / 256;
}

exact ring_truth_lon_texel(const struct truth_focus *f, int level)
{
    exact radius = sinl(PI_EXACT * exp2l(-level)), out = sinl(f->colatitude);
    exact span = radius < out ? 2 * asinl(radius / out) : 2 * PI_EXACT;
    exact share = 2 * PI_EXACT;
    for (int k = 0; k < level - 1 && share / 2 >= span; k++) share /= 2;
    return share / 512;
}
