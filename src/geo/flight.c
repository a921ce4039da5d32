// Between two keys the ground point runs along their geodesic. How far it has come is a monotone
// function not of time but of the integral of the altitude over time: the ground then passes at an
// even rate on the screen while the altitude changes by powers, and at constant altitude this is
// plain time. Everything else is a monotone function of time.
#include "geo/flight.h"

#include <geodesic.h>
#include <stdbool.h>
#include <stdlib.h>

#include "base/memory.h"

#define DEGREE (M_PI / 180)

// Keys nearer than this are one place: no direction leads from one to the other.
#define SAME_PLACE_M 1e-3

// Value and slope at a knot of a piecewise cubic.
struct knot {
    double x, y, slope;
};

struct leg {
    struct geod_geodesicline line; // from key i to key i + 1
    double length;                 // m, 0 when the keys are one place
    double relative_heading; // at key i, to the geodesic's azimuth (to north when length is 0)
};

struct flight {
    int count;
    double area_scale; // the altitude's unit in the integral, so that it stays near time
    flight_key *keys;  // count, as given but with every fov known or 0
    struct leg *legs;  // count - 1
    struct knot *log_altitude, *distance, *turn, *pitch, *roll, *fov; // count each
};

static double wrap_half(double angle)
{
    return geo_wrap_lon(angle);
}

// Slope at the end knot 0 of three, by the parabola through them, held where it would break
// monotony.
//   source  Fritsch & Butland 1984 as in SLATEC PCHIM (pchst)
static double end_slope(double h0, double h1, double d0, double d1)
{
    double slope = ((2 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
    if (slope * d0 <= 0) return 0;
    if (d0 * d1 <= 0 && fabs(slope) > 3 * fabs(d0)) return 3 * d0;
    return slope;
}

static double secant(const struct knot *a, const struct knot *b)
{
    return b->x > a->x ? (b->y - a->y) / (b->x - a->x) : 0;
}

// Slopes that keep each piece between its knots' values and the whole once continuously
// differentiable.
//   source  Fritsch & Butland 1984: weighted harmonic mean of the neighbouring secants
static void knots_smooth(struct knot *k, int count)
{
    if (count < 2) return;
    for (int i = 1; i + 1 < count; i++) {
        double h0 = k[i].x - k[i - 1].x, h1 = k[i + 1].x - k[i].x;
        double d0 = secant(&k[i - 1], &k[i]), d1 = secant(&k[i], &k[i + 1]);
        double w0 = h0 + 2 * h1, w1 = 2 * h0 + h1;
        k[i].slope = d0 * d1 > 0 ? (w0 + w1) / (w0 / d0 + w1 / d1) : 0;
    }
    double first = secant(&k[0], &k[1]), last = secant(&k[count - 2], &k[count - 1]);
    k[0].slope = first;
    k[count - 1].slope = last;
    if (count < 3) return;
    double h0 = k[1].x - k[0].x, h1 = k[2].x - k[1].x;
    k[0].slope = end_slope(h0, h1, first, secant(&k[1], &k[2]));
    h0 = k[count - 1].x - k[count - 2].x;
    h1 = k[count - 2].x - k[count - 3].x;
    k[count - 1].slope = end_slope(h0, h1, last, secant(&k[count - 3], &k[count - 2]));
}

// The cubic between knots i and i + 1.
static double knots_at(const struct knot *k, int i, double x)
{
    double h = k[i + 1].x - k[i].x;
    if (!(h > 0)) return k[i].y;
    double t = (x - k[i].x) / h;
    double rise = k[i + 1].y - k[i].y;
    double a = h * k[i].slope - rise, b = rise - h * k[i + 1].slope;
    return k[i].y + t * rise + t * (1 - t) * (a * (1 - t) + b * t);
}

// Integral of the altitude from key i to `time`, in units of area_scale: Gauss-Legendre, 3 points
// on 48 panels.
static double altitude_area(const struct flight *f, int i, double time)
{
    enum { PANELS = 48 };
    const double node = sqrt(0.6);
    double begin = f->keys[i].time_s, half = (time - begin) / (2 * PANELS), sum = 0;
    for (int p = 0; p < PANELS; p++) {
        double middle = begin + (2 * p + 1) * half;
        sum += 5 * exp(knots_at(f->log_altitude, i, middle - node * half)) +
               8 * exp(knots_at(f->log_altitude, i, middle)) +
               5 * exp(knots_at(f->log_altitude, i, middle + node * half));
    }
    return sum * half / (9 * f->area_scale);
}

// The heading key b has when its place is named by the latitude and longitude of key a, to which it
// is equal.
static double heading_moved(const geo_camera *a, const geo_camera *b)
{
    geo_camera moved = *b;
    moved.position = a->position;
    geo_camera_orient(&moved, geo_eye_from_ecef(b));
    return moved.heading;
}

// Prepares leg i; returns the turn relative to the geodesic along it, rad.
static double leg_init(struct flight *f, int i, const struct geod_geodesic *g)
{
    struct leg *leg = &f->legs[i];
    const geo_camera *a = &f->keys[i].camera, *b = &f->keys[i + 1].camera;
    double azimuth_a, azimuth_b;
    geod_inverse(g, a->position.lat / DEGREE, a->position.lon / DEGREE, b->position.lat / DEGREE,
                 b->position.lon / DEGREE, &leg->length, &azimuth_a, &azimuth_b);
    if (leg->length < SAME_PLACE_M) {
        leg->length = 0;
        leg->relative_heading = a->heading;
        return wrap_half(heading_moved(a, b) - a->heading);
    }
    geod_inverseline(&leg->line, g, a->position.lat / DEGREE, a->position.lon / DEGREE,
                     b->position.lat / DEGREE, b->position.lon / DEGREE, 0);
    leg->relative_heading = wrap_half(a->heading - azimuth_a * DEGREE);
    return wrap_half(b->heading - azimuth_b * DEGREE - leg->relative_heading);
}

// Keys without a field of view take the nearest earlier one's, or else the nearest later one's; 0
// when none has one.
static void fill_fov(flight_key *keys, int count)
{
    double fov = 0;
    for (int i = count - 1; i >= 0; i--) {
        if (keys[i].camera.fov_y > 0) fov = keys[i].camera.fov_y;
    }
    for (int i = 0; i < count; i++) {
        if (keys[i].camera.fov_y > 0) fov = keys[i].camera.fov_y;
        keys[i].camera.fov_y = fov;
    }
}

static bool key_valid(const flight_key *key)
{
    const geo_camera *c = &key->camera;
    return isfinite(key->time_s) && fabs(c->position.lat) <= M_PI / 2 &&
           isfinite(c->position.lon) && c->position.height > 0 && isfinite(c->position.height) &&
           isfinite(c->heading) && isfinite(c->pitch) && isfinite(c->roll) && c->fov_y < M_PI;
}

static bool keys_valid(const flight_key *keys, int count)
{
    for (int i = 0; i < count; i++) {
        if (!key_valid(&keys[i])) return false;
        if (i && !(keys[i].time_s > keys[i - 1].time_s)) return false;
    }
    return count >= 1;
}

static void knots_over_time(struct flight *f)
{
    for (int i = 0; i < f->count; i++) {
        const flight_key *k = &f->keys[i];
        double roll =
            i ? f->roll[i - 1].y + wrap_half(k->camera.roll - f->roll[i - 1].y) : k->camera.roll;
        f->log_altitude[i] = (struct knot){.x = k->time_s, .y = log(k->camera.position.height)};
        f->pitch[i] = (struct knot){.x = k->time_s, .y = k->camera.pitch};
        f->roll[i] = (struct knot){.x = k->time_s, .y = roll};
        f->fov[i] = (struct knot){.x = k->time_s, .y = k->camera.fov_y};
    }
    knots_smooth(f->log_altitude, f->count);
    knots_smooth(f->pitch, f->count);
    knots_smooth(f->roll, f->count);
    knots_smooth(f->fov, f->count);
}

// Distance over the altitude's integral, and turn over time: cumulated over the legs. Needs the
// knots over time.
static void knots_over_legs(struct flight *f, geo_ellipsoid e)
{
    struct geod_geodesic g;
    geod_init(&g, e.a, (e.a - e.b) / e.a);
    f->distance[0] = (struct knot){0};
    f->turn[0] = (struct knot){.x = f->keys[0].time_s};
    for (int i = 0; i + 1 < f->count; i++) {
        double turn = leg_init(f, i, &g), end = f->keys[i + 1].time_s;
        f->turn[i + 1] = (struct knot){.x = end, .y = f->turn[i].y + turn};
        f->distance[i + 1] = (struct knot){.x = f->distance[i].x + altitude_area(f, i, end),
                                           .y = f->distance[i].y + f->legs[i].length};
    }
    knots_smooth(f->distance, f->count);
    knots_smooth(f->turn, f->count);
}

struct flight *flight_create(geo_ellipsoid e, const flight_key *keys, int count)
{
    if (!keys_valid(keys, count)) return NULL;
    size_t n = (size_t)count;
    struct flight *f = NEW(struct flight);
    f->count = count;
    f->area_scale = keys[0].camera.position.height;
    f->keys = NEW_ARRAY(flight_key, n);
    for (int i = 0; i < count; i++) f->keys[i] = keys[i];
    fill_fov(f->keys, count);
    f->legs = NEW_ARRAY(struct leg, n);
    struct knot **tables[] = {&f->log_altitude, &f->distance, &f->turn,
                              &f->pitch,        &f->roll,     &f->fov};
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++) {
        *tables[i] = NEW_ARRAY(struct knot, n);
    }
    knots_over_time(f);
    knots_over_legs(f, e);
    return f;
}

void flight_destroy(struct flight **flight)
{
    struct flight *f = *flight;
    if (!f) return;
    free(f->keys);
    free(f->legs);
    free(f->log_altitude);
    free(f->distance);
    free(f->turn);
    free(f->pitch);
    free(f->roll);
    free(f->fov);
    free(f);
    *flight = NULL;
}

double flight_duration_s(const struct flight *flight)
{
    return flight->keys[flight->count - 1].time_s - flight->keys[0].time_s;
}

// Ground point and heading on leg i at a time.
static void leg_at(const struct flight *f, int i, double time, geo_camera *c)
{
    const struct leg *leg = &f->legs[i];
    double heading = leg->relative_heading + knots_at(f->turn, i, time) - f->turn[i].y;
    if (leg->length > 0) {
        double area = f->distance[i].x + altitude_area(f, i, time);
        double along = knots_at(f->distance, i, area) - f->distance[i].y;
        double lat, lon, azimuth;
        geod_position(&leg->line, clamp_double(along, 0, leg->length), &lat, &lon, &azimuth);
        c->position.lat = clamp_double(lat * DEGREE, -M_PI / 2, M_PI / 2);
        c->position.lon = geo_wrap_lon(lon * DEGREE);
        heading += azimuth * DEGREE;
    }
    c->heading = heading - 2 * M_PI * floor(heading / (2 * M_PI));
}

geo_camera flight_at(const struct flight *flight, double time_s)
{
    const flight_key *first = flight->keys, *last = &flight->keys[flight->count - 1];
    if (!(time_s > first->time_s)) return first->camera;
    if (time_s >= last->time_s) return last->camera;
    int low = 0, high = flight->count - 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (flight->keys[middle].time_s <= time_s) low = middle;
        else high = middle;
    }
    geo_camera c = flight->keys[low].camera;
    leg_at(flight, low, time_s, &c);
    c.position.height = exp(knots_at(flight->log_altitude, low, time_s));
    c.pitch = knots_at(flight->pitch, low, time_s);
    c.roll = wrap_half(knots_at(flight->roll, low, time_s));
    c.fov_y = knots_at(flight->fov, low, time_s);
    return c;
}
