// Per level one plan at a time: the window it aims at, the strips that are missing from it, the
// jobs in work for it. Invariant: the texture holds right samples all over `valid`, or recast ones
// while `recast` says so. The strips of a plan lie outside valid ∩ target, or stand for the same
// samples, and no two samples of one window share a texel, so `valid` has to shrink to that only
// when the first strip is handed out, and grows to the target when the last one was uploaded.
#include "clipmap/clipmap.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "clipmap/jobs.h"
#include "clipmap/strips.h"

static const size_t DEFAULT_STAGING = (size_t)32 << 20;
static const float CUBIC_BEYOND = 12 / 128.0f; // of their range: its weights below 0

struct plan {
    bool active, begun; // begun: a strip was handed out
    bool again;         // all of the window, in place
    double until_s;     // the samples handed out stand until then
    window window;      // aimed at; its rect counts columns on the turn the plan was made on
    window_rect target; // of it, what will be valid at the end
    clip_strips strips; // not yet queued
    int live;           // queued, ready or handed out
};

struct level {
    window window, held;
    window_rect valid; // in columns of `held`
    clip_range range;  // covers the heights in `valid`
    double until_s; // those in `valid` stand until then (clock_now_s): INFINITY but for stand-ins
    bool filled_again; // since anything is missing
    bool recast;       // some of those in `valid` are
    struct plan plan;
    double lag;  // frames that its plans took of late
    bool outrun; // would be late in any case: see outruns()
    struct clip_bounds *bounds;
};

struct clipmap {
    clipmap_params params;
    struct clip_jobs *jobs;
    struct level *levels;
    int last; // finest wanted; -1 before the first move
    double lat, lon;
    double step_lat, step_lon;   // of the focus, the last two frames alike
    double last_step;            // its length between the last two moves
    double ahead_lat, ahead_lon; // where the focus will be if it goes on so
    bool moved;                  // since the frame began
    double lag;                  // frames from asking for a strip to having it, of late
    size_t frame_left;           // samples
    int held_from;               // finest level that the frame's samples reached
    struct clipmap_counters counters;
    bool (*derives)(void *user, const window *w, const window *coarser);
    void *derives_user;
    void (*recast)(void *user, const window *from, const window *to, window_rect valid);
    void *recast_user;
};

status clipmap_create(struct pyramid *pyramid, struct pool *pool, const clipmap_params *params,
                      struct clipmap **out)
{
    const window_shape *shape = &params->shape;
    assert(params->levels > 0 && params->levels <= CLIPMAP_MAX_LEVELS);
    assert(shape->cols >= CLIP_CELL && !(shape->cols & (shape->cols - 1)));
    assert(window_at(shape, params->levels - 1, 0, 0, 1).zoom <= GRID_MAX_ZOOM);
    struct clipmap *c = NEW(struct clipmap);
    c->params = *params;
    c->last = -1;
    c->frame_left = SIZE_MAX;
    c->held_from = CLIPMAP_MAX_LEVELS;
    if (!c->params.samples_frame)
        c->params.samples_frame = (size_t)shape->rows * (size_t)shape->cols;
    if (c->params.samples_frame < (size_t)shape->cols)
        c->params.samples_frame = (size_t)shape->cols;
    if (!c->params.staging_bytes) c->params.staging_bytes = DEFAULT_STAGING;
    c->levels = NEW_ARRAY(struct level, (size_t)params->levels);
    for (int i = 0; i < params->levels; i++) {
        struct level *l = &c->levels[i];
        l->window.level = l->held.level = i;
        l->range = CLIP_RANGE_EMPTY;
        l->until_s = INFINITY;
        if (params->layer == LAYER_HEIGHT) l->bounds = clip_bounds_create(shape->rows, shape->cols);
    }
    struct clip_jobs_params jobs = {
        pyramid, pool, params->layer, *shape, c->params.staging_bytes, params->residuals};
    status s = clip_jobs_create(&jobs, &c->jobs);
    if (s) clipmap_destroy(&c);
    *out = c;
    return s;
}

void clipmap_destroy(struct clipmap **clipmap)
{
    struct clipmap *c = *clipmap;
    if (!c) return;
    clip_jobs_destroy(&c->jobs);
    for (int i = 0; i < c->params.levels; i++) clip_bounds_destroy(&c->levels[i].bounds);
    free(c->levels);
    free(c);
    *clipmap = NULL;
}

void clipmap_set_derives(struct clipmap *c,
                         bool (*derives)(void *user, const window *w, const window *coarser),
                         void *user)
{
    c->derives = derives;
    c->derives_user = user;
}

void clipmap_set_recast(struct clipmap *c,
                        void (*recast)(void *user, const window *from, const window *to,
                                       window_rect valid),
                        void *user)
{
    c->recast = recast;
    c->recast_user = user;
}

static bool alike(const window *a, const window *b)
{
    return a->share == b->share && a->derived == b->derived;
}

// What is valid of a window of the level, in the window's own columns.
static window_rect valid_in(const struct clipmap *c, const struct level *l, const window *w)
{
    if (window_rect_empty(l->valid) || !alike(&l->held, w)) return (window_rect){0};
    window_rect v = window_rect_turned(&c->params.shape, w->share, l->valid, w->rect);
    return window_rect_intersect(v, w->rect);
}

static bool all_valid(const struct clipmap *c, const struct level *l)
{
    return !window_rect_empty(l->window.rect) &&
           window_rect_equal(valid_in(c, l, &l->window), l->window.rect);
}

static bool level_complete(const struct clipmap *c, const struct level *l)
{
    return all_valid(c, l) && !l->recast;
}

static void plan_start(struct clipmap *c, struct level *l)
{
    bool again = l->recast || all_valid(c, l);
    window_rect kept = again ? (window_rect){0} : valid_in(c, l, &l->window);
    l->plan = (struct plan){.active = true,
                            .again = again,
                            .until_s = INFINITY,
                            .window = l->window,
                            .target = l->window.rect};
    l->plan.strips = clip_strips_missing(&c->params.shape, l->window.rect, kept);
}

// The first strip is handed out: texels outside the target are about to be overwritten.
static void plan_begin(struct clipmap *c, struct level *l)
{
    struct plan *p = &l->plan;
    window_rect kept = valid_in(c, l, &p->window);
    if (window_rect_empty(kept)) {
        c->counters.refills++;
        l->until_s = INFINITY;
        l->recast = false;
    }
    p->begun = true;
    l->held = p->window; // l->range still covers what is left
    l->valid = window_rect_intersect(kept, p->target);
}

// What was made of a level that has been filled again has to be made again.
static void stand_in_for_next(struct clipmap *c, const struct level *l)
{
    int next = l->window.level + 1;
    if (next < c->params.levels && c->levels[next].held.derived) c->levels[next].until_s = 0;
}

static void plan_finish_if_done(struct clipmap *c, struct level *l)
{
    struct plan *p = &l->plan;
    if (!p->active || p->live || clip_strips_left(&p->strips, clip_jobs_max_rows(c->jobs))) return;
    p->active = false;
    if (!p->begun) return;
    l->until_s = fmin(p->again ? (double)INFINITY : l->until_s, p->until_s);
    if (p->again) {
        l->recast = false;
        stand_in_for_next(c, l);
    }
    l->held = p->window;
    l->valid = p->target;
    if (l->bounds) l->range = clip_bounds_of(l->bounds, l->held.share, l->valid);
}

static void plan_cancel(struct clipmap *c, struct level *l)
{
    if (!l->plan.active) return;
    clip_jobs_drop(c->jobs, l->window.level, (window_rect){0});
    l->plan.active = false;
}

// Fits the plan to the level's new window: strips that have nothing in it are dropped, and a plan
// that has nothing in it is cancelled. A plan that still has a part in it runs to its end; the
// margins absorb the lag.
static void plan_refit(struct clipmap *c, struct level *l)
{
    struct plan *p = &l->plan;
    if (!p->active) return;
    if (!alike(&p->window, &l->window)) {
        plan_cancel(c, l);
        return;
    }
    window_rect now =
        window_rect_turned(&c->params.shape, p->window.share, l->window.rect, p->window.rect);
    window_rect keep = window_rect_intersect(p->target, now);
    if (window_rect_empty(keep)) {
        plan_cancel(c, l);
        return;
    }
    bool cut = clip_strips_clip(&p->strips, keep);
    int dropped = clip_jobs_drop(c->jobs, l->window.level, keep);
    p->live -= dropped;
    if (cut || dropped) p->target = keep;
    plan_finish_if_done(c, l);
}

// A level whose share is twice or half of what it was keeps what it has, in the new columns. Its
// plan is off by now.
static void recast(struct clipmap *c, struct level *l)
{
    const window from = l->held, *to = &l->window;
    if (!c->recast || window_rect_empty(l->valid) || from.derived != to->derived) return;
    if (abs(from.share - to->share) != 1) return;
    window_rect valid = window_rect_recast(&c->params.shape, from.share, l->valid, to);
    if (window_rect_empty(valid)) return;
    c->recast(c->recast_user, &from, to, valid);
    float beyond = to->share > from.share ? CUBIC_BEYOND * (l->range.max - l->range.min) : 0;
    l->range = (clip_range){l->range.min - beyond, l->range.max + beyond};
    l->held = *to;
    l->valid = valid;
    l->recast = true;
}

// Coarse levels first, and in a level what lies nearest to where the focus is going to be: in [i,
// i + 1/2].
static double priority_of(const struct clipmap *c, const window *w, window_rect r)
{
    const window_shape *shape = &c->params.shape;
    double row, col;
    window_coordinates(shape, w, c->ahead_lat, c->ahead_lon, &row, &col);
    row -= 0.5 * (double)(r.row0 + r.row1);
    col -= 0.5 * (double)(r.col0 + r.col1);
    double far = fmax(fabs(row) / shape->rows, fabs(col) / shape->cols);
    return w->level + 0.5 * fmin(far, 1);
}

// Will the level's window share nothing with today's by the time that strips asked for now have
// come? Once it was so, half of it has to be shared again, or what is asked for would be given up
// in the next frame. Levels 0 and 1 hold the whole circle and are never left.
static bool outruns(const struct clipmap *c, const struct level *l)
{
    if (l->window.level < 2 || c->counters.frames == 0) return false;
    double rows = fabs(c->step_lat) / window_step_lat(&l->window);
    double cols = fabs(c->step_lon) / window_step_lon(&c->params.shape, &l->window);
    if (l->window.share == 0) cols = 0;
    double lag = fmax(c->lag, 1) * (l->outrun ? 2 : 1);
    return rows * lag >= c->params.shape.rows || cols * lag >= c->params.shape.cols;
}

// From the first level that is outrun on, all finer ones are left alone.
static void find_outrun(struct clipmap *c)
{
    bool outrun = false;
    for (int i = 0; i <= c->last; i++) {
        struct level *l = &c->levels[i];
        outrun = l->outrun = outrun || outruns(c, l);
        if (outrun) plan_cancel(c, l);
    }
}

// Queues strips coarse to fine while there are blocks: a level is planned when every coarser one is
// complete or in work.
static void feed(struct clipmap *c)
{
    bool room = true;
    int max_rows = clip_jobs_max_rows(c->jobs);
    for (int i = 0; i <= c->last && room; i++) {
        struct level *l = &c->levels[i];
        struct plan *p = &l->plan;
        if (l->outrun) break;
        if (!p->active && level_complete(c, l)) continue;
        if (!p->active) plan_start(c, l);
        clip_strips rest = p->strips;
        for (window_rect r; room && clip_strips_take(&rest, max_rows, &r);) {
            room = clip_jobs_add(c->jobs, &p->window, r, priority_of(c, &p->window, r),
                                 c->counters.frames);
            if (!room) break;
            p->strips = rest;
            p->live++;
        }
    }
    clip_jobs_start(c->jobs);
}

// The next AHEAD frames, if the focus goes on as between the last three: a single step is a jump,
// not a flight.
static void look_ahead(struct clipmap *c, double lat, double lon)
{
    enum { AHEAD = 8 };
    bool first = c->last < 0;
    double dlat = first ? 0 : lat - c->lat, dlon = first ? 0 : remainder(lon - c->lon, 2 * M_PI);
    double length = hypot(dlat, dlon * cos(lat));
    double alike = length > 0 ? fmin(1, c->last_step / length) : 0;
    c->last_step = length;
    c->step_lat = alike * dlat;
    c->step_lon = alike * dlon;
    c->ahead_lat = clamp_double(lat + AHEAD * c->step_lat, -M_PI / 2, M_PI / 2);
    c->ahead_lon = lon + AHEAD * c->step_lon;
}

// Nobody moves: nothing is outrun.
static void stand(struct clipmap *c)
{
    look_ahead(c, c->lat, c->lon);
    find_outrun(c);
}

void clipmap_move(struct clipmap *c, double lat, double lon, int last)
{
    assert(last >= 0);
    if (last >= c->params.levels) last = c->params.levels - 1;
    bool moved = c->last < 0 || lat != c->lat || lon != c->lon;
    clip_jobs_retry(c->jobs);
    clip_jobs_wake(c->jobs);
    look_ahead(c, lat, lon);
    for (int i = 0; i < c->params.levels && moved; i++) {
        struct level *l = &c->levels[i];
        l->window = window_at(&c->params.shape, i, lat, lon, c->params.ring_bound);
        const window *coarser = i ? &l[-1].window : NULL;
        if (i && c->derives && c->derives(c->derives_user, &l->window, coarser))
            l->window.derived = coarser->derived + 1;
        plan_refit(c, l);
        if (i <= last) recast(c, l);
    }
    for (int i = last + 1; i <= c->last; i++) plan_cancel(c, &c->levels[i]);
    c->lat = lat;
    c->lon = lon;
    c->last = last;
    c->moved |= moved;
    find_outrun(c);
    feed(c);
}

// While anything is missing each level is filled again but once: a source that goes on failing
// would have coarse levels filled again and again, and finer ones never.
static void fill_stand_ins_again(struct clipmap *c)
{
    bool complete = clipmap_complete(c, NULL);
    for (int i = 0; i <= c->last; i++) {
        struct level *l = &c->levels[i];
        l->filled_again &= !complete;
        if (l->until_s == (double)INFINITY || l->plan.active || l->outrun) continue;
        if (l->filled_again || !level_complete(c, l) || clip_jobs_clock() < l->until_s) continue;
        l->filled_again = !complete;
        plan_start(c, l);
    }
}

static uint32_t levels_held_back(const struct clipmap *c)
{
    uint32_t levels = 0;
    for (int i = 0; i <= c->last; i++) {
        const struct level *l = &c->levels[i];
        bool held_back = l->outrun || i >= c->held_from;
        if (held_back && !level_complete(c, l)) levels |= (uint32_t)1 << i;
    }
    return levels;
}

void clipmap_begin_frame(struct clipmap *c, bool unbounded)
{
    const double forget = 0.9; // half a second brings 20 frames of lag down to 1
    c->counters.yielded = levels_held_back(c);
    c->counters.frames++;
    c->counters.frame_samples = 0;
    c->frame_left = unbounded ? SIZE_MAX : c->params.samples_frame;
    c->held_from = CLIPMAP_MAX_LEVELS;
    if (!c->moved && c->last >= 0) {
        c->lag *= forget;
        stand(c);
        fill_stand_ins_again(c);
        feed(c);
    } else fill_stand_ins_again(c);
    c->moved = false;
}

// Most strips find their tiles in memory and come at once; it is the others that make a level late.
static void learn_lag(struct clipmap *c, const struct clip_job *job)
{
    double more = (double)(c->counters.frames - job->frame) - c->lag;
    c->lag += more > 0 ? more / 2 : more / 128;
}

// Does a level hold, in columns twice as wide and not recast, what the four-point filter makes a
// job's rectangle of?
static bool holds_parents(const struct clipmap *c, const struct level *l,
                          const struct clip_job *job)
{
    if (l->held.share + 1 != job->window.share || window_rect_empty(l->valid)) return false;
    if (l->recast) return false;
    window_rect needs = window_rect_parents(job->rect);
    window_rect valid = window_rect_turned(&c->params.shape, l->held.share, l->valid, needs);
    return window_rect_equal(window_rect_intersect(valid, needs), needs);
}

static bool may_derive(void *user, const struct clip_job *job)
{
    const struct clipmap *c = user;
    const struct level *l = &c->levels[job->window.level - 1];
    return l->held.derived + 1 == job->window.derived && holds_parents(c, l, job);
}

// What was filled while a source failed, or made on the GPU, may have other bits.
static bool may_add(const struct clipmap *c, const struct clip_job *job)
{
    if (!job->residuals || !job->has_residuals || job->window.derived) return false;
    const struct level *l = &c->levels[job->window.level - 1];
    return l->held.zoom + 1 == job->window.zoom && !l->held.derived &&
           l->until_s == (double)INFINITY && holds_parents(c, l, job);
}

// What is written over valid samples may reach beyond them.
static void cover(struct level *l, const clip_range *ranges, int count)
{
    for (int i = 0; i < count; i++) {
        l->range.min = fminf(l->range.min, ranges[i].min);
        l->range.max = fmaxf(l->range.max, ranges[i].max);
    }
}

bool clipmap_next_strip(struct clipmap *c, size_t budget, clipmap_strip *out)
{
    clip_jobs_unblock(c->jobs, may_derive, c);
    struct clip_job *job = clip_jobs_ready(c->jobs);
    if (!job) return false;
    const window_shape *shape = &c->params.shape;
    bool derived = job->window.derived > 0, adds = may_add(c, job);
    size_t cols = (size_t)(job->rect.col1 - job->rect.col0), row_bytes = (adds ? 2 : 4) * cols;
    size_t rows = (size_t)(job->rect.row1 - job->rect.row0 - job->handed);
    if (!derived && rows > budget / row_bytes) rows = budget / row_bytes;
    if (rows > c->frame_left / cols) {
        rows = c->frame_left / cols;
        c->held_from = job->window.level;
    }
    if (!rows) return false;
    struct level *l = &c->levels[job->window.level];
    if (!l->plan.begun) plan_begin(c, l);
    if (!job->handed) learn_lag(c, job);
    l->plan.until_s = fmin(l->plan.until_s, job->until_s);

    clipmap_strip s = {.level = job->window.level,
                       .window = job->window,
                       .rect = job->rect,
                       .again = l->plan.again};
    s.rect.row0 += job->handed;
    s.rect.row1 = s.rect.row0 + (int64_t)rows;
    s.rows = (int)rows;
    s.cols = (int)(s.rect.col1 - s.rect.col0);
    s.tex_row = window_texel(s.rect.row0, shape->rows);
    s.tex_col = window_texel(s.rect.col0, shape->cols);
    size_t samples = rows * cols, handed = (size_t)job->handed * cols;
    s.samples = (const unsigned char *)job->samples + 4 * handed;
    if (adds) s.residuals = job->residuals + handed;
    s.bytes = derived ? 0 : rows * row_bytes;
    if (l->bounds && !derived) {
        int cells = clip_bounds_cells(s.tex_col, s.cols);
        const clip_range *ranges = job->ranges + job->handed * cells;
        clip_bounds_write(l->bounds, s.window.share, s.rect, ranges, true);
        if (s.again) cover(l, ranges, s.rows * cells);
    }
    job->handed += s.rows;
    c->counters.strips++;
    c->counters.samples += samples;
    c->counters.residuals += adds ? samples : 0;
    c->counters.frame_samples += samples;
    if (c->frame_left != SIZE_MAX) {
        c->frame_left -= samples;
        if (c->counters.frame_samples > c->counters.most_frame_samples)
            c->counters.most_frame_samples = c->counters.frame_samples;
    }
    c->counters.bytes += s.bytes;
    *out = s;
    return true;
}

void clipmap_uploaded(struct clipmap *c, const clipmap_strip *strip)
{
    struct clip_job *job = clip_jobs_of_samples(c->jobs, strip->samples);
    struct level *l = &c->levels[strip->level];
    bool orphan = job->state == CLIP_JOB_ORPHAN;
    job->uploaded += strip->rows;
    if (strip->ranges && !orphan) {
        clip_bounds_write(l->bounds, strip->window.share, strip->rect, strip->ranges, false);
        if (strip->again)
            cover(l, strip->ranges, strip->rows * clip_bounds_cells(strip->tex_col, strip->cols));
    }
    if (job->uploaded < (orphan ? job->handed : (int)(job->rect.row1 - job->rect.row0))) return;
    clip_jobs_release(c->jobs, job);
    if (!orphan) l->plan.live--;
    plan_finish_if_done(c, l);
    feed(c);
}

clipmap_level clipmap_level_state(const struct clipmap *c, int level)
{
    assert(level >= 0 && level < c->params.levels);
    const struct level *l = &c->levels[level];
    clipmap_level s = {.window = l->window, .held = l->held, .valid = l->valid};
    if (window_rect_empty(l->valid)) s.held = l->window;
    if (s.held.share == s.window.share) {
        window now = l->window;
        now.derived = l->held.derived; // until the first strip that is made otherwise
        s.held.rect =
            window_rect_turned(&c->params.shape, s.held.share, s.held.rect, s.window.rect);
        s.valid = valid_in(c, l, &now);
    }
    if (window_rect_empty(s.valid)) s.valid = (window_rect){0};
    s.complete = level_complete(c, l);
    clip_range r = window_rect_empty(s.valid) ? CLIP_RANGE_EMPTY : l->range;
    s.min = r.min;
    s.max = r.max;
    return s;
}

bool clipmap_complete(const struct clipmap *c, int *missing)
{
    int strips = 0;
    bool complete = true;
    for (int i = 0; i <= c->last; i++) {
        const struct level *l = &c->levels[i];
        if (level_complete(c, l)) continue;
        int left = 0;
        if (l->plan.active)
            left = l->plan.live + clip_strips_left(&l->plan.strips, clip_jobs_max_rows(c->jobs));
        strips += left ? left : 1;
        complete = false;
    }
    if (missing) *missing = strips;
    return complete;
}

bool clipmap_provisional(const struct clipmap *c)
{
    bool any = false;
    for (int i = 0; i <= c->last; i++) {
        const struct level *l = &c->levels[i];
        any |= l->until_s != (double)INFINITY || (l->plan.active && l->plan.again);
    }
    return any;
}

bool clipmap_wait(struct clipmap *c, double timeout_s)
{
    const double longest_s = 1e6;
    double deadline = clip_jobs_clock() + fmin(fmax(timeout_s, 0), longest_s);
    if (c->last >= 0) stand(c); // who waits does not move
    for (;;) {
        clip_jobs_wake(c->jobs);
        feed(c);
        clip_jobs_unblock(c->jobs, may_derive, c);
        enum clip_wait result = clip_jobs_wait(c->jobs, deadline);
        if (result != CLIP_WAIT_CHANGED) return result == CLIP_WAIT_READY;
    }
}

void clipmap_counters(const struct clipmap *c, struct clipmap_counters *out)
{
    *out = c->counters;
    out->staging_bytes = clip_jobs_bytes(c->jobs);
    out->waiting = clip_jobs_wake(c->jobs);
}
