#include "reference/compare_edges.h"

#include <stdlib.h>

#include "base/log.h"

enum { ORIENT_PX = 5 }; // an edge's direction comes from those so near
// Of a pixel with sky beside it no slope is known. Where a surface bends away from the ray, 1 / z
// goes with the root of the distance from the limb, so that its last step is at most (1 - 0) /
// (sqrt 2 - 1) = 2.41 times the one before: what is beyond that is another surface.
#define LIMB_STEEPENS 2.5

static double inverse(const depth_picture *p, int x, int y)
{
    if (x < 0 || y < 0 || x >= p->width || y >= p->height) return NAN;
    return 1 / (double)p->z_m[(size_t)y * (size_t)p->width + (size_t)x];
}

// The mean of the changes on both sides; the smaller where they disagree as at an edge, the one
// where there is only one.
static double change(double before, double after)
{
    if (isnan(before)) return isnan(after) ? 0 : after;
    if (isnan(after)) return before;
    double mean = 0.5 * (before + after), less = fabs(before) < fabs(after) ? before : after;
    return fabs(mean) <= 2 * fabs(less) ? mean : less;
}

depth_plane depth_plane_at(const depth_picture *p, int x, int y)
{
    double w = inverse(p, x, y);
    return (depth_plane){.w = w,
                         .right = change(w - inverse(p, x - 1, y), inverse(p, x + 1, y) - w),
                         .down = change(w - inverse(p, x, y - 1), inverse(p, x, y + 1) - w)};
}

// A plane m . P = 1 has 1 / z = m . D on the ray D = (X, Y, 1).
dvec3 depth_plane_normal(const depth_picture *p, const depth_plane *plane, int x, int y)
{
    double mx = plane->right / p->scale, my = -plane->down / p->scale;
    double ray_x = (x + 0.5 - 0.5 * p->width) * p->scale,
           ray_y = (0.5 * p->height - y - 0.5) * p->scale;
    return dvec3_normalize(dvec3_make(-mx, -my, mx * ray_x + my * ray_y - plane->w));
}

// Distance, in pixel sizes, of the point of 1 / z = w from the plane of a pixel, on its ray.
static double step_px(const depth_picture *p, int x, int y, depth_plane plane, double w)
{
    double mx = plane.right / p->scale, my = -plane.down / p->scale;
    double ray_x = (x + 0.5 - 0.5 * p->width) * p->scale,
           ray_y = (0.5 * p->height - y - 0.5) * p->scale;
    double length = dvec3_length(dvec3_make(mx, my, plane.w - mx * ray_x - my * ray_y));
    if (w <= 0) return INFINITY;
    return fabs(1 / w - 1 / plane.w) * plane.w * plane.w / (length * p->scale);
}

// The four pixels in a line of which the middle two are asked about.
struct line {
    int x, y, dx, dy;
};

static int edge_at(const depth_picture *p, struct line l)
{
    double near = inverse(p, l.x, l.y), far = inverse(p, l.x + l.dx, l.y + l.dy);
    if (isnan(near) || isnan(far)) return isnan(near) ? isnan(far) ? 0 : -2 : 2;
    double before = inverse(p, l.x - l.dx, l.y - l.dy),
           after = inverse(p, l.x + 2 * l.dx, l.y + 2 * l.dy);
    double slope_near = near - before, slope_far = after - far;
    if (isnan(before)) slope_near = isnan(after) ? 0 : LIMB_STEEPENS * slope_far;
    if (isnan(after)) slope_far = isnan(before) ? 0 : LIMB_STEEPENS * slope_near;
    double of_near = near + slope_near - far, of_far = far - slope_far - near;
    if (!(of_near * of_far < 0)) return 0;
    depth_plane a = depth_plane_at(p, l.x, l.y), b = depth_plane_at(p, l.x + l.dx, l.y + l.dy);
    *(l.dx ? &a.right : &a.down) = slope_near;
    *(l.dx ? &b.right : &b.down) = slope_far;
    double step = fmin(step_px(p, l.x, l.y, a, far - slope_far),
                       step_px(p, l.x + l.dx, l.y + l.dy, b, near + slope_near));
    int strength = (step > EDGE_STEP_PX) + (step > EDGE_FAINT_PX);
    if (strength == 2 && isnan(before + after)) strength = 3;
    return near > far ? strength : -strength;
}

status edges_find(const depth_picture *p, edge_picture *out)
{
    size_t width = (size_t)p->width, pixels = width * (size_t)p->height;
    *out = (edge_picture){calloc(pixels, 1), calloc(pixels, 1)};
    if (!out->right || !out->below) {
        log_error("compare: out of memory for the edges of %dx%d pixels", p->width, p->height);
        edges_deinit(out);
        return ERR_MEMORY;
    }
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++) {
            size_t at = (size_t)y * width + (size_t)x;
            if (x + 1 < p->width)
                out->right[at] = (signed char)edge_at(p, (struct line){x, y, 1, 0});
            if (y + 1 < p->height)
                out->below[at] = (signed char)edge_at(p, (struct line){x, y, 0, 1});
        }
    return OK;
}

void edges_deinit(edge_picture *e)
{
    free(e->right);
    free(e->below);
    *e = (edge_picture){0};
}

static void mark_box(const depth_picture *p, int x0, int y0, int x1, int y1, unsigned char *mask)
{
    for (int y = y0 < 0 ? 0 : y0; y <= y1 && y < p->height; y++)
        for (int x = x0 < 0 ? 0 : x0; x <= x1 && x < p->width; x++)
            mask[(size_t)y * (size_t)p->width + (size_t)x] = 1;
}

void edges_mark(const depth_picture *p, const edge_picture *e, unsigned char *mask)
{
    for (int y = 0; y < p->height; y++)
        for (int x = 0; x < p->width; x++) {
            size_t at = (size_t)y * (size_t)p->width + (size_t)x;
            if (abs(e->right[at]) >= 2) mark_box(p, x, y - 1, x + 1, y + 1, mask);
            if (abs(e->below[at]) >= 2) mark_box(p, x - 1, y, x + 1, y + 1, mask);
        }
}

static double nearness(double dx, double dy)
{
    double rest = 1 - (dx * dx + dy * dy) / (ORIENT_PX * ORIENT_PX);
    return rest > 0 ? rest * rest : 0;
}

// The mean normal of the edges about (x, y), the middle of an edge, its components by Crofton: an
// edge of length L whose normal has the angle t to the rows crosses L |cos t| rows and L |sin t|
// columns.
static dvec3 edge_normal(const depth_picture *p, const edge_picture *e, double x, double y)
{
    dvec3 n = {0, 0, 0};
    for (int j = (int)y - ORIENT_PX; j <= (int)y + ORIENT_PX; j++)
        for (int i = (int)x - ORIENT_PX; i <= (int)x + ORIENT_PX; i++) {
            if (i < 0 || j < 0 || i >= p->width || j >= p->height) continue;
            size_t at = (size_t)j * (size_t)p->width + (size_t)i;
            n.x += e->right[at] / 2 * nearness(i + 0.5 - x, j - y); // faint: 0
            n.y += e->below[at] / 2 * nearness(i - x, j + 0.5 - y);
        }
    return n;
}

struct matcher {
    const depth_picture *pb, *pa;
    const edge_picture *b, *a;
    unsigned char *mask;
    const edge_sink *sink;
};

static const signed char *along(const edge_picture *e, bool row)
{
    return row ? e->right : e->below;
}

// Pixels that an edge lies off (signed) along its row or column; false: none within `search`.
// *cut: the picture ends before the search does.
static bool find_like(const struct matcher *m, int x, int y, bool row, int search, int *offset,
                      bool *cut)
{
    const depth_picture *pa = m->pa;
    size_t width = (size_t)pa->width, at = (size_t)y * width + (size_t)x, step = row ? 1 : width;
    int sense = along(m->b, row)[at], place = row ? x : y,
        last = (row ? pa->width : pa->height) - 2;
    size_t near_side = sense > 0 ? 0 : step, far_side = step - near_side;
    double near = m->pb->z_m[at + near_side];
    double factor = isnan(m->pb->z_m[at + far_side]) ? LIMB_DEPTH_FACTOR : EDGE_DEPTH_FACTOR;
    *cut = place < search || place + search > last;
    for (int k = 0; k <= 2 * search; k++) {
        int off = k & 1 ? -(k + 1) / 2 : k / 2, to = place + off;
        if (to < 0 || to > last) continue;
        size_t there = row ? (size_t)y * width + (size_t)to : (size_t)to * width + (size_t)x;
        if (along(m->a, row)[there] * sense <= 0) continue;
        double ratio = pa->z_m[there + near_side] / near;
        if (ratio > factor || ratio < 1 / factor) continue;
        *offset = off;
        return true;
    }
    return false;
}

static void match_one(const struct matcher *m, int x, int y, bool row)
{
    int sense = along(m->b, row)[(size_t)y * (size_t)m->pb->width + (size_t)x], offset = 0;
    if (abs(sense) != 2) return;
    dvec3 n = edge_normal(m->pb, m->b, row ? x + 0.5 : x, row ? y : y + 0.5);
    bool counted = (fabs(n.x) >= fabs(n.y)) == row;
    double cosine = fabs(row ? n.x : n.y) / hypot(n.x, n.y);
    if (!counted || isnan(cosine)) cosine = 1; // NaN: as many edges of the opposite sense about it
    bool cut, found = find_like(m, x, y, row, (int)(EDGE_SEARCH_PX / cosine), &offset, &cut);
    if (found && m->mask && offset) {
        int from = offset > 0 ? 1 : offset + 1, to = offset > 0 ? offset : 0;
        if (row) mark_box(m->pb, x + from, y, x + to, y, m->mask);
        else mark_box(m->pb, x, y + from, x, y + to, m->mask);
    }
    if (!counted || !m->sink || (!found && cut)) return;
    int near_x = x + (row && sense < 0), near_y = y + (!row && sense < 0);
    double beyond = inverse(m->pb, x + (row && sense > 0), y + (!row && sense > 0));
    m->sink->found(m->sink->user, near_x, near_y, isnan(beyond),
                   found ? abs(offset) * cosine : NAN);
}

void edges_match(const depth_picture *pb, const edge_picture *b, const depth_picture *pa,
                 const edge_picture *a, unsigned char *mask, const edge_sink *sink)
{
    struct matcher m = {pb, pa, b, a, mask, sink};
    for (int y = 0; y < pb->height; y++)
        for (int x = 0; x < pb->width; x++) {
            match_one(&m, x, y, true);
            match_one(&m, x, y, false);
        }
}
