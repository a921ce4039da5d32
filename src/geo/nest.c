// Latitudes and longitudes come from whole indices times a step that is halved from level to level,
// so a vertex has bit for bit the same place in all levels that share it.
#include "geo/nest.h"

#include <math.h>

#include "base/vec.h"

bool nest_size_valid(int n)
{
    return n >= NEST_N_MIN && n <= NEST_N_MAX && (n & (n + 1)) == 0;
}

static double step_of(int n, int level)
{
    return ldexp(2 * M_PI / (n + 1), -level);
}

int nest_globe_level(bool plane, int level)
{
    return plane ? level - NEST_PLANE_LEVELS : level;
}

// m - 1 or m within the coarser level: with q = floor(place), the coarser floor is floor(q / 2).
static int64_t first_vertex(int n, double place)
{
    return 2 * (int64_t)floor(place / 2) - (n - 3) / 2;
}

nest_square nest_square_at(int n, int level, double lat, double lon)
{
    return nest_square_over((geo_ellipsoid){0}, n, level, lat, lon);
}

nest_square nest_square_over(geo_ellipsoid e, int n, int level, double lat, double lon)
{
    nest_square s = {.n = n, .level = level, .plane = geo_is_plane(e)};
    s.step = step_of(n, nest_globe_level(s.plane, level));
    s.circle = (int64_t)(n + 1) << level >> (level - nest_globe_level(s.plane, level));
    double turns = (lon + M_PI) / (2 * M_PI);
    double row = (M_PI / 2 - lat) / s.step;
    double column = (turns - floor(turns)) * (double)s.circle;
    s.row = first_vertex(n, row);
    s.column = first_vertex(n, column);
    s.view_row = row - (double)s.row;
    s.view_column = column - (double)s.column;
    return s;
}

double nest_half_side(int n, int level)
{
    return ((n - 1) / 2 - 1) * step_of(n, level);
}

double nest_transition_width(int n)
{
    return n / 10.0;
}

double nest_alpha(const nest_square *s, double row, double column)
{
    double away = fmax(fabs(row - s->view_row), fabs(column - s->view_column));
    double width = nest_transition_width(s->n);
    return clamp_double((away - ((s->n - 1) / 2 - width - 1)) / width, 0, 1);
}

int nest_finest_level(int n, double radius, double above, int levels, double *share)
{
    double side = radius * n * step_of(n, 0), least = 2.5 * fmax(above, 1e-3);
    int level = (int)clamp_double(floor(log2(side / least)), 0, levels - 1);
    *share = clamp_double(2 * (log2(side / least) - level), 0, 1);
    return level;
}

bool nest_holds_pole(const struct geo_focus *focus, double angle)
{
    return !geo_is_plane(focus->ellipsoid) && fabs(focus->reduced) + angle >= M_PI / 2;
}

static int coarsest_reaching(int n, double reach, int wider, int levels)
{
    int level = 0;
    while (level + 1 < levels && nest_half_side(n, level + 1 - wider) >= reach) level++;
    return level;
}

int nest_coarsest_level(int n, const struct geo_focus *focus, double angle, int levels)
{
    if (geo_is_plane(focus->ellipsoid))
        return coarsest_reaching(n, angle, NEST_PLANE_LEVELS, levels);
    if (nest_holds_pole(focus, angle)) return 0;
    // Geodetic latitudes are further apart than reduced ones by no more than A/B.
    double up = angle * fmax(focus->r, 1 / focus->r);
    double aside = asin(fmin(1, sin(angle) / focus->cb));
    return coarsest_reaching(n, fmax(up, aside), 0, levels);
}

double nest_latitude(const nest_square *s, double row)
{
    double from_north = (double)s->row + row;
    if (!s->plane) from_north = clamp_double(from_north, 0, (double)(s->circle / 2));
    return M_PI / 2 - from_north * s->step;
}

// From tan(b) = q tan(lat) by the tangent of a difference: no cancellation near the focus.
nest_row nest_row_at(const nest_square *s, const struct geo_focus *f, int i)
{
    double lat = nest_latitude(s, i);
    if (s->plane) {
        float north = (float)(lat - f->lat);
        return (nest_row){.s = north, .w = 1, .dlat = north};
    }
    int64_t row = s->row + i;
    bool pole = row <= 0 || row >= s->circle / 2;
    double q = 1 / f->r, cl = pole ? 0 : cos(lat), sl = pole ? copysign(1, lat) : sin(lat);
    double up = q * sin(lat - f->lat), along = cl * cos(f->lat) + q * q * (sl * sin(f->lat));
    double length = hypot(up, along);
    nest_row r = {.s = (float)(up / length), .dlat = (float)(lat - f->lat)};
    r.c = (float)(along > 0 ? up * up / (length * (length + along)) : 1 - along / length);
    r.w = (float)(cl / hypot(cl, q * sl));
    return r;
}

nest_column nest_column_at(const nest_square *s, const struct geo_focus *f, int i)
{
    if (s->plane) {
        float east = (float)((double)(s->column + i) * s->step - M_PI - f->lon);
        return (nest_column){.t = east, .dlon = east};
    }
    int64_t circle = s->circle, column = (s->column + i) % circle;
    double lon = (double)(column < 0 ? column + circle : column) * s->step - M_PI;
    double half = sin((lon - f->lon) / 2);
    return (nest_column){.t = (float)sin(lon - f->lon),
                         .d = (float)(2 * half * half),
                         .dlon = (float)((i - s->view_column) * s->step)};
}
