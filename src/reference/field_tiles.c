// Which tiles are in sight. A tile's ground lies in a sphere about its middle: any place of it is
// reached along a meridian, a parallel and the vertical, each no longer than its bound.
#include "reference/field_tiles.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "reference/body.h"

#define RAD (M_PI / 180)

// A tile's samples shape the ground up to two samples beyond it, when bicubic; twice that.
#define REACH_SAMPLES 4
// Listing these takes a few seconds.
#define MAX_CANDIDATES (1 << 24)

int field_wrap(int64_t col, int64_t cols)
{
    int64_t r = col % cols;
    return (int)(r < 0 ? r + cols : r);
}

// Half the angle, on the unit sphere of reduced latitude, of the cap about the eye that holds all
// ground in sight. Heights in [low, high] lie there at radii in [1 + low / b, 1 + high / b]; a ray
// that comes below the first has met the ground. Nothing within `far` is farther aside than the
// tangent to the sphere about the eye.
static double cap_angle(geo_ellipsoid e, const field_sight *s, double low, double high)
{
    double small = fmin(e.a, e.b), inner = 1 + fmin(low, 0) / small,
           outer = 1 + fmax(high, 0) / small;
    dvec3 eye = {s->eye.x / e.a, s->eye.y / e.a, s->eye.z / e.b};
    double r = dvec3_length(eye);
    double angle = acos(fmin(1, inner / fmax(r, inner))) + acos(inner / outer);
    if (s->far > 0 && s->far / small < r) angle = fmin(angle, asin(s->far / small / r));
    return fmin(angle + 1e-6, M_PI);
}

// The rectangle about the cap, in tiles.
struct span {
    int first, last;  // tile rows
    double lon, half; // rad
};

// On a plane: the rectangle of the map about what is within `far`.
static struct span plane_span(const struct field *f)
{
    geo_ellipsoid e = field_ellipsoid(f);
    const field_sight *sight = &f->params.sight;
    double lat, lon, height, step = grid_step_lat(f->params.zoom) * TILE_SIZE,
                             reach = sight->far > 0 ? sight->far / e.a : INFINITY;
    body_locate(e, sight->eye, &lat, &lon, &height);
    lat *= RAD;
    lon *= RAD;
    double north = clamp_double(lat + reach, e.south, e.north),
           south = clamp_double(lat - reach, e.south, e.north),
           east = clamp_double(lon + reach, e.west, e.east),
           west = clamp_double(lon - reach, e.west, e.east);
    int last = grid_rows(f->params.zoom) - 1;
    struct span s = {.lon = 0.5 * (west + east), .half = 0.5 * (east - west)};
    s.first = (int)clamp_double(floor((M_PI / 2 - north) / step) - 1, 0, last);
    s.last = (int)clamp_double(floor((M_PI / 2 - south) / step) + 1, 0, last);
    return s;
}

static struct span span_of(const struct field *f, double angle)
{
    if (geo_is_plane(field_ellipsoid(f))) return plane_span(f);
    geo_ellipsoid e = field_ellipsoid(f);
    dvec3 eye = f->params.sight.eye;
    double lat = atan2(eye.z / e.b, hypot(eye.x, eye.y) / e.a);
    double north = fmin(lat + angle, M_PI / 2), south = fmax(lat - angle, -M_PI / 2);
    bool pole = lat + angle >= M_PI / 2 || lat - angle <= -M_PI / 2;
    struct span s = {.lon = atan2(eye.y, eye.x)};
    s.half = pole ? M_PI : asin(fmin(1, sin(angle) / cos(lat))) + 1e-6;
    double step = grid_step_lat(f->params.zoom) * TILE_SIZE;
    north = atan2(sin(north) * e.a, cos(north) * e.b);
    south = atan2(sin(south) * e.a, cos(south) * e.b);
    int last = grid_rows(f->params.zoom) - 1;
    s.first = (int)fmin(fmax(floor((M_PI / 2 - north) / step) - 1, 0), last);
    s.last = (int)fmin(fmax(floor((M_PI / 2 - south) / step) + 1, 0), last);
    return s;
}

static bool list_candidates(struct field *f, const struct span *s, size_t *count)
{
    f->first_row = s->first;
    f->rows = s->last - s->first + 1;
    *count = 0;
    if (f->rows > MAX_CANDIDATES) return false;
    f->row = NEW_ARRAY(struct field_row, (size_t)f->rows);
    for (int i = 0; i < f->rows; i++) {
        struct field_row *r = &f->row[i];
        r->cols = grid_cols(f->params.zoom, s->first + i);
        double width = 2 * M_PI / r->cols;
        double west = floor((s->lon - s->half + M_PI) / width) - 1,
               east = floor((s->lon + s->half + M_PI) / width) + 1;
        bool all = east - west + 1 >= r->cols;
        r->first = all ? 0 : (int)west;
        r->count = all ? r->cols : (int)(east - west + 1);
        r->at = *count;
        *count += (size_t)r->count;
        if (*count > MAX_CANDIDATES) return false;
    }
    return true;
}

// Every point of the tile's ground, and of the ground that its samples shape, is within `radius`
// of `centre`. turned: whole turns of longitude to where it is looked for, which a plane tells
// apart.
struct ball {
    dvec3 centre;
    double radius;
};

static struct ball ball_of(geo_ellipsoid e, tile_id id, int turned, double low, double high)
{
    double west, south, east, north;
    grid_bounds(id, &west, &south, &east, &north);
    if (turned) west += turned * 2 * M_PI, east += turned * 2 * M_PI;
    dvec3 middle =
        body_point(e, 0.5 * (south + north) / RAD, 0.5 * (west + east) / RAD, 0.5 * (low + high));
    double lat_room = REACH_SAMPLES * grid_step_lat(id.zoom),
           lon_room = REACH_SAMPLES * (east - west) / TILE_SIZE;
    double meridian = fmax(e.a * e.a / e.b, e.b * e.b / e.a), prime = fmax(e.a * e.a / e.b, e.a);
    double nearest = fmin(fabs(south), fabs(north)) - lat_room;
    double parallel = south < lat_room && north > -lat_room ? 1 : cos(fmax(nearest, 0));
    if (geo_is_plane(e)) parallel = 1;
    double top = fmax(high, 0);
    double radius = (meridian + top) * (0.5 * (north - south) + lat_room) +
                    (prime + top) * parallel * fmin(0.5 * (east - west) + lon_room, M_PI) +
                    0.5 * (high - low);
    return (struct ball){middle, radius * (1 + 1e-9)};
}

static bool in_sight(const field_sight *s, const struct ball *ball)
{
    dvec3 to = dvec3_sub(ball->centre, s->eye);
    double distance = dvec3_length(to), radius = ball->radius + 1e-3 + 1e-9 * distance;
    if (distance + radius < s->near || (s->far > 0 && distance - radius > s->far)) return false;
    for (int i = 0; i < s->sides; i++)
        if (dvec3_dot(to, s->side[i]) < -radius) return false;
    return true;
}

static status add_tile(struct field *f, tile_id id, size_t *room)
{
    if (f->tiles == FIELD_MAX_TILES) return ERR_ARGUMENT;
    if (f->tiles == *room) {
        *room = *room ? 2 * *room : 64;
        struct field_tile *more = realloc(f->tile, *room * sizeof *more);
        if (!more) return ERR_MEMORY;
        f->tile = more;
    }
    f->tile[f->tiles++] = (struct field_tile){.id = id};
    return OK;
}

status field_list_tiles(struct field *f, double low, double high)
{
    geo_ellipsoid e = field_ellipsoid(f);
    struct span span = span_of(f, cap_angle(e, &f->params.sight, low, high));
    size_t candidates, room = 0;
    if (!list_candidates(f, &span, &candidates)) return ERR_ARGUMENT;
    f->index = malloc(candidates * sizeof *f->index);
    status s = f->index ? OK : ERR_MEMORY;
    for (int i = 0; i < f->rows && !s; i++) {
        const struct field_row *r = &f->row[i];
        for (int j = 0; j < r->count && !s; j++) {
            tile_id id = {LAYER_HEIGHT, f->params.zoom, f->first_row + i,
                          field_wrap(r->first + j, r->cols)};
            int turned = (int)floor((double)(r->first + j) / r->cols);
            struct ball ball = ball_of(e, id, turned, low, high);
            bool seen = in_sight(&f->params.sight, &ball);
            f->index[r->at + (size_t)j] = seen ? (int32_t)f->tiles : -1;
            if (seen) s = add_tile(f, id, &room);
        }
    }
    return s;
}

void field_forget_tiles(struct field *f)
{
    for (size_t i = 0; i < f->tiles; i++) {
        free(f->tile[i].maxima);
        free(f->tile[i].minima);
    }
    free(f->tile);
    free(f->row);
    free(f->index);
    f->tile = NULL;
    f->row = NULL;
    f->index = NULL;
    f->tiles = 0;
}
