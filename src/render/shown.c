#include "render/shown.h"

#include <math.h>

// What joins a level already shown grows in at up to GROWTH windows a second, so that catching up
// is a moving ramp and not a jump.
static const double GROWTH = 12;

bool shown_empty(const struct shown *s)
{
    return s->row0 >= s->row1 || s->col0 >= s->col1;
}

bool shown_whole(const struct shown *s, const clipmap_level *l)
{
    return window_rect_empty(l->valid)
               ? shown_empty(s)
               : s->zoom == l->held.zoom && s->share == l->held.share && s->fade >= 1 &&
                     s->row0 == (double)l->valid.row0 && s->row1 == (double)l->valid.row1 &&
                     s->col0 == (double)l->valid.col0 && s->col1 == (double)l->valid.col1;
}

// Shrinks with `valid` at once, grows towards it by at most `rows` and `cols`.
static void follow_valid(struct shown *s, window_rect valid, double rows, double cols)
{
    double row0 = (double)valid.row0, row1 = (double)valid.row1, col0 = (double)valid.col0,
           col1 = (double)valid.col1;
    s->row0 = fmax(row0, fmin(s->row0, row1) - rows);
    s->row1 = fmin(row1, fmax(s->row1, row0) + rows);
    s->col0 = fmax(col0, fmin(s->col0, col1) - cols);
    s->col1 = fmin(col1, fmax(s->col1, col0) + cols);
}

// Moved by whole turns of the share so that its middle is as near to that of `valid` as can be.
static void turn(struct shown *s, const window_shape *shape, window_rect valid)
{
    double circle = ldexp(shape->cols, s->share),
           off = 0.5 * ((double)(valid.col0 + valid.col1) - s->col0 - s->col1);
    s->col0 += circle * rint(off / circle);
    s->col1 += circle * rint(off / circle);
}

void shown_recast(struct shown *s, const window_shape *shape, const window *from, const window *to,
                  window_rect valid)
{
    if (shown_empty(s) || s->zoom != from->zoom || s->share != from->share) return;
    double columns = ldexp(1, to->share - from->share);
    bool circle = s->col1 - s->col0 == ldexp(shape->cols, from->share);
    s->share = to->share;
    s->col0 = circle ? (double)valid.col0 : columns * s->col0;
    s->col1 = circle ? (double)valid.col1 : columns * s->col1;
    turn(s, shape, valid);
    s->col0 = fmax(s->col0, (double)valid.col0);
    s->col1 = fmin(s->col1, (double)valid.col1);
    s->row0 = fmax(s->row0, (double)valid.row0);
    s->row1 = fmin(s->row1, (double)valid.row1);
}

bool shown_advance(struct shown *s, const clipmap_level *state, const window_shape *shape,
                   double fade_s, double dt_s)
{
    if (shown_whole(s, state)) return false;
    if (window_rect_empty(state->valid)) {
        *s = (struct shown){0};
        return true;
    }
    turn(s, shape, state->valid);
    bool fresh = shown_empty(s) || s->zoom != state->held.zoom || s->share != state->held.share ||
                 s->row0 >= (double)state->valid.row1 || s->row1 <= (double)state->valid.row0 ||
                 s->col0 >= (double)state->valid.col1 || s->col1 <= (double)state->valid.col0;
    if (fresh) s->fade = 0;
    s->zoom = state->held.zoom;
    s->share = state->held.share;
    double grow = fresh || dt_s < 0 ? 1e9 : GROWTH * dt_s;
    follow_valid(s, state->valid, grow * shape->rows, grow * shape->cols);
    s->fade = fade_s <= 0 || dt_s < 0 ? 1 : fminf(1, s->fade + (float)(dt_s / fade_s));
    return true;
}
