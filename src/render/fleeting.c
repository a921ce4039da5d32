#include "render/fleeting.h"

#include <math.h>

// Samples at the border of the level before that are weighed less (lib/windows.glsl): beyond them
// it would have to be blended with one that is no longer there.
enum { RAMP = 6 };

int fleeting_kept(const struct pyramid *pyramid, const window_shape *shape, int levels)
{
    int finest = pyramid_meta(pyramid)->max_zoom[LAYER_HEIGHT], kept = 2;
    while (kept < levels && window_at(shape, kept, 0, 0, 1).zoom <= finest) kept++;
    return kept;
}

// How far the made heights can lie above all those that they are made of, D the largest difference
// of neighbours there. Along a line the four-point filter (planet/upsample.c) gives what lies
// between two samples and 18/128 of D at most; of rows filtered so, which differ by no more than
// 152/128 of D, the same once more: 0.31 D. The new neighbours differ by no more than 88/128 *
// 152/128 of D and twice what is added. Over all zooms that is 1.7 D and 4.4 times the sum of what
// is added.
static void find_rise(struct fleeting *f, const struct pyramid *pyramid, const window_shape *shape)
{
    const struct planet_meta *m = pyramid_meta(pyramid);
    double most = pyramid_synthesis(pyramid) == SYNTHESIS_ERODED ? 2 : 8.2,
           sum = 0; // times its rms
    for (int i = f->kept; i < f->levels; i++) {
        synthesis_scale s =
            synthesis_scale_of(window_at(shape, i, 0, 0, 1).zoom - 1, m->synthesis_gain,
                               m->max_zoom[LAYER_HEIGHT], m->ellipsoid.a);
        sum += most * (double)s.share * (double)s.steep;
    }
    f->rise = (float)(4.4 * sum);
    f->rise_share = 1.7f;
}

void fleeting_init(struct fleeting *f, const struct pyramid *pyramid, const window_shape *shape,
                   int kept, int levels)
{
    *f = (struct fleeting){.kept = kept, .levels = levels, .made = kept - 1};
    find_rise(f, pyramid, shape);
}

void fleeting_move(struct fleeting *f, const struct deepen *deepen, const window_shape *shape,
                   double lat, double lon, double ring_bound)
{
    window before = window_at(shape, f->kept - 1, lat, lon, ring_bound);
    bool can = true;
    for (int i = f->kept; i < f->levels; i++) {
        window w = window_at(shape, i, lat, lon, ring_bound);
        can = can && deepen_can(deepen, &w, w.rect, &before);
        if (!can) w.rect = (window_rect){0};
        f->window[i] = before = w;
    }
}

clipmap_level fleeting_state(const struct fleeting *f, const window_shape *shape, int level,
                             const struct shown *before, const clipmap_level *data)
{
    const window *w = &f->window[level];
    clipmap_level s = {.window = *w, .held = *w, .complete = true};
    window_rect needs = window_rect_parents(w->rect);
    needs =
        (window_rect){needs.row0 - RAMP, needs.row1 + RAMP, needs.col0 - RAMP, needs.col1 + RAMP};
    window_rect has = {(int64_t)ceil(before->row0), (int64_t)floor(before->row1),
                       (int64_t)ceil(before->col0), (int64_t)floor(before->col1)};
    bool fits = before->zoom + 1 == w->zoom && before->share + 1 == w->share && before->fade >= 1;
    if (window_rect_empty(w->rect) || window_rect_empty(has) || !fits) {
        s.min = HUGE_VALF;
        s.max = -HUGE_VALF;
        return s;
    }
    has = window_rect_turned(shape, before->share, has, needs);
    bool circle = before->share == 0 && has.col1 - has.col0 == shape->cols;
    bool columns = circle || (has.col0 <= needs.col0 && has.col1 >= needs.col1);
    if (columns && has.row0 <= needs.row0 && has.row1 >= needs.row1) s.valid = w->rect;
    s.min = data->min; // no sample lies lower than all that it is made of
    s.max = data->max + f->rise + f->rise_share * (data->max - data->min);
    return s;
}
