#include "clipmap/strips.h"

// The end, at most `end`, of the stretch from `from` that does not wrap on an axis of `size`
// texels.
static int64_t unwrapped_end(int64_t from, int64_t end, int size)
{
    int64_t e = from - window_texel(from, size) + size;
    return e < end ? e : end;
}

static void add_unwrapped(clip_strips *s, const window_shape *shape, window_rect r)
{
    for (int64_t row = r.row0, row1; row < r.row1; row = row1) {
        row1 = unwrapped_end(row, r.row1, shape->rows);
        for (int64_t col = r.col0, col1; col < r.col1; col = col1) {
            col1 = unwrapped_end(col, r.col1, shape->cols);
            s->rects[s->count++] = (window_rect){row, row1, col, col1};
        }
    }
}

clip_strips clip_strips_missing(const window_shape *shape, window_rect target, window_rect held)
{
    clip_strips s = {.count = 0};
    window_rect parts[4];
    int count = window_rect_missing(target, held, parts);
    for (int i = 0; i < count; i++) add_unwrapped(&s, shape, parts[i]);
    return s;
}

bool clip_strips_take(clip_strips *s, int max_rows, window_rect *out)
{
    while (s->first < s->count && window_rect_empty(s->rects[s->first])) s->first++;
    if (s->first == s->count) return false;
    window_rect *r = &s->rects[s->first];
    *out = *r;
    if (out->row1 - out->row0 > max_rows) out->row1 = out->row0 + max_rows;
    r->row0 = out->row1;
    return true;
}

bool clip_strips_clip(clip_strips *s, window_rect keep)
{
    bool cut = false;
    for (int i = s->first; i < s->count; i++) {
        window_rect r = s->rects[i], k = window_rect_intersect(r, keep);
        if (window_rect_empty(r)) continue;
        if (window_rect_equal(k, r)) continue;
        s->rects[i] = k;
        cut = true;
    }
    return cut;
}

int clip_strips_left(const clip_strips *s, int max_rows)
{
    int64_t left = 0;
    for (int i = s->first; i < s->count; i++) {
        window_rect r = s->rects[i];
        if (!window_rect_empty(r)) left += (r.row1 - r.row0 + max_rows - 1) / max_rows;
    }
    return (int)left;
}
