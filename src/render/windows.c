// Invariant: a texel inside a level's `valid` rectangle holds that sample's height and its normal;
// strips still to come lie outside it. Normals of a strip wait until its plan is whole, because
// they need the neighbours.
#include "render/windows.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/vec.h"
#include "gpu/context.h"
#include "render/fleeting.h"
#include "render/normals.h"
#include "render/recast.h"
#include "render/residuals.h"
#include "render/shown.h"
#include "render/texture_array.h"

enum { MAX_COLOR_LEVELS = 18, COLOR_LEVELS_BEYOND = 2 };

// A level filled from nothing fades in over this time; fleeting ones do one after the other.
static const double FADE_S = 0.35, FLEETING_FADE_S = 0.08;

// A ring is sampled by a window before it fills that: at this lead it takes 152 of the 168 rows on
// each side of the focus (of 256 across a ring), and the levels' transition ends at 133. What is
// left has room for the ramp at the border, the snapping, and data that lag behind. Without it
// 2.4 pixels of error for 99.9 % in the Alps became 2.0 with more triangles only.
static const double LEAD = 0.25;

struct layer {
    struct windows *owner;
    struct clipmap *clipmap;
    window_shape shape;
    int levels, kept; // kept: by the clipmap, the rest is fleeting
    struct fleeting *fleeting;
    GLuint texture;
    struct recast *recast;
    GLenum format, type;
    struct shown shown[CLIPMAP_MAX_LEVELS];
    uint64_t version[CLIPMAP_MAX_LEVELS];
};

struct windows {
    struct deepen *deepen;       // NULL: no level is made from the one before
    struct residuals *residuals; // NULL: none come
    struct fleeting fleeting;
    struct layer height, color;
    struct normals *normals;
    struct gpu_upload *upload;
    geo_ellipsoid ellipsoid;
    double ring_bound, lat, lon;
    size_t gpu_bytes, derived_bytes,
        told_bytes;   // sent for deepen, ever; sent in all, ever, as told
    int last_height;  // finest level wanted
    double lead;      // by how many levels the heights are finer than the rings
    char defines[64]; // before the shaders that use the arrays
    bool heights_changed, changed;
};

static bool derives(void *user, const window *w, const window *coarser)
{
    return deepen_can(user, w, w->rect, coarser);
}

static status create_deepen(struct windows *w, const windows_params *p)
{
    if (!p->derive || !pyramid_synthesises(p->pyramid)) return OK;
    status s = deepen_create(p->pyramid, &w->height.shape, w->height.levels, CLIPMAP_MAX_ROWS,
                             w->defines, &w->deepen);
    if (s) return s;
    w->gpu_bytes += deepen_gpu_bytes(w->deepen);
    clipmap_set_derives(w->height.clipmap, derives, w->deepen);
    return OK;
}

// More samples across reach the same fineness with fewer levels.
static int finer_levels(int texels)
{
    int finer = 0;
    for (; texels > 256; texels >>= 1) finer++;
    return finer;
}

static status create_layers(struct windows *w, const windows_params *p)
{
    const struct planet_meta *meta = pyramid_meta(p->pyramid);
    clipmap_params c = {.layer = LAYER_HEIGHT,
                        .shape = window_height_shape(p->texels > 256 ? p->texels : 256),
                        .samples_frame = p->update_samples_frame,
                        .ring_bound = w->ring_bound,
                        .residuals = p->residuals};
    int levels = p->levels - finer_levels(p->texels);
    bool all = !p->fleeting || !pyramid_synthesises(p->pyramid);
    c.levels = all ? levels : fleeting_kept(p->pyramid, &c.shape, levels);
    fleeting_init(&w->fleeting, p->pyramid, &c.shape, c.levels, levels);
    const char *flat = geo_is_plane(w->ellipsoid) ? "#define FLAT 1\n" : "";
    int used = snprintf(w->defines, sizeof w->defines, "%s", flat);
    if (c.levels < levels)
        snprintf(w->defines + used, sizeof w->defines - (size_t)used, "#define KEPT_LEVELS %d\n",
                 c.levels);
    w->height = (struct layer){.shape = c.shape,
                               .levels = levels,
                               .kept = c.levels,
                               .fleeting = &w->fleeting,
                               .format = GL_RED,
                               .type = GL_FLOAT};
    status s = clipmap_create(p->pyramid, p->pool, &c, &w->height.clipmap);
    if (s) return s;

    // Level i lies at zoom i + 1. Two levels more than the data have: a window's columns may be
    // four times as wide as the data's (a ring of half the circle or more), and what is seen from
    // near would lose detail where a coarse ring's share of the circle doubles.
    int finest = meta->max_zoom[LAYER_COLOR] > meta->max_zoom[LAYER_NIGHT]
                     ? meta->max_zoom[LAYER_COLOR]
                     : meta->max_zoom[LAYER_NIGHT];
    int wanted = finest < 0 ? 2 : finest + COLOR_LEVELS_BEYOND;
    c.layer = LAYER_COLOR;
    c.shape = WINDOW_COLOR;
    c.levels = wanted < p->levels ? wanted : p->levels;
    if (c.levels > MAX_COLOR_LEVELS) c.levels = MAX_COLOR_LEVELS;
    w->color = (struct layer){.shape = c.shape,
                              .levels = c.levels,
                              .kept = c.levels,
                              .format = GL_RGBA,
                              .type = GL_UNSIGNED_BYTE};
    return clipmap_create(p->pyramid, p->pool, &c, &w->color.clipmap);
}

static status create_textures(struct windows *w)
{
    gpu_context_forgive();
    bool fleeting = w->height.kept < w->height.levels;
    int layers = w->height.kept + (fleeting ? FLEETING_LAYERS : 0),
        convexity_layers = w->height.kept + (fleeting ? FLEETING_CONVEXITY_LAYERS : 0);
    w->height.texture = texture_array(GL_R32F, &w->height.shape, layers, GL_LINEAR);
    normals_params n = {w->ellipsoid, w->height.shape, layers, convexity_layers, w->defines};
    status s = normals_create(&n, &w->normals);
    if (s) return s;
    // Colour takes its memory whatever the planet's data, so that memory does not depend on them.
    w->color.texture = texture_array(GL_SRGB8_ALPHA8, &w->color.shape, MAX_COLOR_LEVELS, GL_LINEAR);
    w->gpu_bytes = texture_array_bytes(&w->height.shape, layers, 4) +
                   normals_gpu_bytes(w->normals) +
                   texture_array_bytes(&w->color.shape, MAX_COLOR_LEVELS, 4);
    if (glGetError() == GL_NO_ERROR) return OK;
    log_error("the GPU refused %zu MiB of textures for the terrain windows", w->gpu_bytes >> 20);
    return ERR_GPU;
}

static void recast(void *user, const window *from, const window *to, window_rect valid)
{
    struct layer *l = user;
    struct windows *w = l->owner;
    recast_make(l->recast, to, to->share < from->share, valid);
    shown_recast(&l->shown[to->level], &l->shape, from, to, valid);
    l->version[to->level]++;
    w->changed = true;
    if (l != &w->height) return;
    normals_make(w->normals, l->texture, to, valid);
    w->heights_changed = true;
}

static status create_recast(struct windows *w, struct layer *l)
{
    recast_params p = {l->shape, l->texture, l->kept, l == &w->color, w->defines};
    l->owner = w;
    clipmap_set_recast(l->clipmap, recast, l);
    return recast_create(&p, &l->recast);
}

static status create_residuals(struct windows *w, const windows_params *p)
{
    if (!p->residuals) return OK;
    status s = residuals_create(&w->height.shape, w->defines, &w->residuals);
    if (!s) w->gpu_bytes += residuals_gpu_bytes(w->residuals);
    return s;
}

status windows_create(const windows_params *params, struct windows **out)
{
    struct windows *w = NEW(struct windows);
    w->ellipsoid = pyramid_meta(params->pyramid)->ellipsoid;
    w->ring_bound = fmax(w->ellipsoid.a / w->ellipsoid.b, w->ellipsoid.b / w->ellipsoid.a);
    w->lead = params->texels < 256 ? -1 : LEAD; // the windows of 256 rows serve for 128
    status s = create_layers(w, params);
    if (!s) s = create_textures(w);
    if (!s) s = create_recast(w, &w->height);
    if (!s) s = create_recast(w, &w->color);
    if (!s) s = create_deepen(w, params);
    if (!s) s = create_residuals(w, params);
    if (!s) s = gpu_upload_create(params->upload_bytes_frame, &w->upload);
    if (s) windows_destroy(&w);
    *out = w;
    return s;
}

void windows_destroy(struct windows **windows)
{
    struct windows *w = *windows;
    if (!w) return;
    clipmap_destroy(&w->height.clipmap);
    deepen_destroy(&w->deepen);
    residuals_destroy(&w->residuals);
    clipmap_destroy(&w->color.clipmap);
    recast_destroy(&w->height.recast);
    recast_destroy(&w->color.recast);
    glDeleteTextures(1, &w->height.texture);
    glDeleteTextures(1, &w->color.texture);
    normals_destroy(&w->normals);
    gpu_upload_destroy(&w->upload);
    free(w);
    *windows = NULL;
}

const char *windows_defines(const struct windows *w)
{
    return w->defines;
}

GLuint windows_heights(const struct windows *w)
{
    return w->height.texture;
}

GLuint windows_normals(const struct windows *w)
{
    return normals_texture(w->normals);
}

GLuint windows_convexity(const struct windows *w)
{
    return normals_convexity(w->normals);
}

GLuint windows_colors(const struct windows *w)
{
    return w->color.texture;
}

size_t windows_gpu_bytes(const struct windows *w)
{
    return w->gpu_bytes;
}

double windows_lead(const struct windows *w)
{
    return w->lead;
}

int windows_color_levels(const struct windows *w)
{
    return w->color.levels;
}

void windows_move(struct windows *w, double lat, double lon, int last_height, int last_color)
{
    w->changed |= lat != w->lat || lon != w->lon;
    w->lat = lat;
    w->lon = lon;
    int finest = (int)fmax(last_height + fmin(w->lead, 0), 0);
    w->last_height = finest < w->height.levels ? finest : w->height.levels - 1;
    clipmap_move(w->height.clipmap, lat, lon,
                 w->last_height < w->height.kept ? w->last_height : w->height.kept - 1);
    if (windows_fleeting(w))
        fleeting_move(&w->fleeting, w->deepen, &w->height.shape, lat, lon, w->ring_bound);
    clipmap_move(w->color.clipmap, lat, lon,
                 last_color < w->color.levels ? last_color : w->color.levels - 1);
}

int windows_last_height(const struct windows *w)
{
    return w->last_height;
}

bool windows_fleeting(const struct windows *w)
{
    return w->height.kept < w->height.levels;
}

int windows_kept(const struct windows *w)
{
    return w->height.kept;
}

void windows_begin_sweep(struct windows *w)
{
    w->fleeting.made = w->height.kept - 1;
}

bool windows_make(struct windows *w, int level, bool normals)
{
    struct fleeting *f = &w->fleeting;
    for (; f->made < level && !shown_empty(&w->height.shown[f->made + 1]); f->made++) {
        const window *next = &f->window[f->made + 1];
        w->derived_bytes += deepen_make(w->deepen, w->height.texture, next, next->rect);
    }
    if (f->made < level || !normals) return f->made == level;
    const window *made = &f->window[level];
    normals_make(w->normals, w->height.texture, made, made->rect);
    return true;
}

static bool whole_circle(const window *held)
{
    return held->share == 0;
}

static void upload(struct windows *w, const struct layer *l, const clipmap_strip *s)
{
    gpu_upload_texture(w->upload, l->texture, s->level, s->tex_col, s->tex_row, s->cols, s->rows,
                       l->format, l->type, s->samples, s->bytes);
}

// What is filled again shows in the next frame, for nothing else of the level changes.
static void note_again(struct windows *w, struct layer *l, const clipmap_strip *strip)
{
    if (!strip->again) return;
    l->version[strip->level]++;
    w->changed = true;
    w->heights_changed |= l == &w->height;
}

// A derived strip is not valid before its ranges are known, some frames after it was begun.
static bool land_derived(struct windows *w)
{
    clipmap_strip strip;
    bool any = false;
    for (; w->deepen && deepen_finished(w->deepen, 0, &strip); any = true) {
        normals_note(w->normals, &strip);
        note_again(w, &w->height, &strip);
        clipmap_uploaded(w->height.clipmap, &strip);
        deepen_release(w->deepen);
    }
    return any;
}

static bool pump_heights(struct windows *w)
{
    clipmap_strip strip;
    bool any = land_derived(w);
    while ((!w->deepen || deepen_has_room(w->deepen)) &&
           clipmap_next_strip(w->height.clipmap, gpu_upload_room(w->upload), &strip)) {
        any = true;
        if (strip.window.derived) {
            w->derived_bytes += deepen_run(w->deepen, w->height.texture, &strip);
            continue;
        }
        if (strip.residuals) residuals_add(w->residuals, w->upload, w->height.texture, &strip);
        else upload(w, &w->height, &strip);
        normals_note(w->normals, &strip);
        note_again(w, &w->height, &strip);
        clipmap_uploaded(w->height.clipmap, &strip);
    }
    return any;
}

static void pump_colors(struct windows *w)
{
    clipmap_strip strip;
    while (clipmap_next_strip(w->color.clipmap, gpu_upload_room(w->upload), &strip)) {
        upload(w, &w->color, &strip);
        note_again(w, &w->color, &strip);
        clipmap_uploaded(w->color.clipmap, &strip);
    }
}

// Of a kept or a fleeting level.
static clipmap_level level_state(const struct layer *l, int level)
{
    if (level < l->kept) return clipmap_level_state(l->clipmap, level);
    clipmap_level data = clipmap_level_state(l->clipmap, l->kept - 1);
    return fleeting_state(l->fleeting, &l->shape, level, &l->shown[level - 1], &data);
}

static double fade_of(const struct layer *l, int level)
{
    return level == 0 ? 0 : level < l->kept ? FADE_S : FLEETING_FADE_S;
}

static bool advance_shown(struct layer *l, double dt_s)
{
    bool changed = false;
    for (int i = 0; i < l->levels; i++) {
        clipmap_level state = level_state(l, i);
        bool advanced = shown_advance(&l->shown[i], &state, &l->shape, fade_of(l, i), dt_s);
        l->version[i] += advanced;
        changed |= advanced;
    }
    return changed;
}

size_t windows_pump(struct windows *w, double dt_s)
{
    clipmap_begin_frame(w->height.clipmap, dt_s < 0);
    clipmap_begin_frame(w->color.clipmap, dt_s < 0);
    if (gpu_upload_begin(w->upload)) {
        bool heights = pump_heights(w);
        pump_colors(w);
        gpu_upload_end(w->upload);
        if (heights) normals_update(w->normals, w->height.texture, w->height.clipmap);
    }
    bool heights = advance_shown(&w->height, dt_s);
    bool colors = advance_shown(&w->color, dt_s);
    w->heights_changed |= heights;
    w->changed |= heights || colors;
    size_t before = w->told_bytes;
    w->told_bytes = gpu_upload_total(w->upload) + w->derived_bytes;
    return w->told_bytes - before;
}

void windows_fill_coarsest(struct windows *w, double timeout_s)
{
    windows_move(w, 0, 0, 0, 0);
    // clipmap_wait returns when a strip is ready; its own timeout bounds each turn.
    for (int turn = 0; turn < 1000; turn++) {
        windows_pump(w, -1);
        if (windows_complete(w)) return;
        glFinish(); // lets the upload ring's share be used again
        if (!windows_wait(w, timeout_s)) return;
    }
}

bool windows_take_heights_changed(struct windows *w)
{
    bool changed = w->heights_changed;
    w->heights_changed = false;
    return changed;
}

bool windows_take_changed(struct windows *w)
{
    bool changed = w->changed;
    w->changed = false;
    return changed;
}

// The level of heights wanted at a level of rings, that there is.
static int window_of(const struct windows *w, double level)
{
    return (int)clamp_double(floor(level + w->lead), 0, w->last_height);
}

// The finest of those that a whole level of rings is sampled by.
static int finest_of(const struct windows *w, int level)
{
    return (int)clamp_double(ceil(level + 1 + w->lead) - 1, 0, w->last_height);
}

uint64_t windows_heights_version(const struct windows *w, int level)
{
    level = finest_of(w, level);
    uint64_t sum = (uint64_t)level << 48;
    for (int i = 0; i <= level; i++) sum += w->height.version[i];
    return sum;
}

bool windows_complete(const struct windows *w)
{
    return clipmap_complete(w->height.clipmap, NULL) && clipmap_complete(w->color.clipmap, NULL);
}

bool windows_provisional(const struct windows *w)
{
    return clipmap_provisional(w->height.clipmap) || clipmap_provisional(w->color.clipmap);
}

static bool all_shown(const struct layer *l)
{
    for (int i = 0; i < l->levels; i++) {
        clipmap_level state = level_state(l, i);
        if (!shown_whole(&l->shown[i], &state)) return false;
    }
    return true;
}

bool windows_settled(const struct windows *w)
{
    return windows_complete(w) && all_shown(&w->height) && all_shown(&w->color);
}

bool windows_wait(struct windows *w, double timeout_s)
{
    clipmap_strip strip;
    if (w->deepen && deepen_busy(w->deepen)) return deepen_finished(w->deepen, timeout_s, &strip);
    if (!clipmap_complete(w->height.clipmap, NULL))
        return clipmap_wait(w->height.clipmap, timeout_s);
    return clipmap_wait(w->color.clipmap, timeout_s);
}

static int list_missing(const struct layer *l, const char *name, char *text, size_t size,
                        size_t *used)
{
    int count = 0;
    for (int i = 0; i < l->levels; i++) {
        clipmap_level s = level_state(l, i);
        if (s.complete) continue;
        count++;
        int n = *used < size ? snprintf(text + *used, size - *used, "%s level %d\n", name, i) : 0;
        *used += n > 0 ? (size_t)n : 0;
    }
    return count;
}

int windows_missing(const struct windows *w, char *text, size_t size)
{
    size_t used = 0;
    if (size) text[0] = 0;
    int count = 0;
    if (!clipmap_complete(w->height.clipmap, NULL))
        count += list_missing(&w->height, "height", text, size, &used);
    if (!clipmap_complete(w->color.clipmap, NULL))
        count += list_missing(&w->color, "color", text, size, &used);
    return count;
}

void windows_count(const struct windows *w, struct windows_counters *out)
{
    struct clipmap_counters h, c;
    clipmap_counters(w->height.clipmap, &h);
    clipmap_counters(w->color.clipmap, &c);
    uint64_t most =
        h.most_frame_samples > c.most_frame_samples ? h.most_frame_samples : c.most_frame_samples;
    *out = (struct windows_counters){
        h.frame_samples + c.frame_samples, most, h.samples, h.residuals, h.yielded, c.yielded};
}

// Where a level has nothing yet, the window that it is going to hold.
static window held_of(const struct layer *l, int level)
{
    clipmap_level state = level_state(l, level);
    bool empty = window_rect_empty(state.valid) || shown_empty(&l->shown[level]);
    return empty ? state.window : state.held;
}

static void fill_level(const struct windows *w, const struct layer *l, int level, float map[4],
                       float torus[4], float valid[4])
{
    clipmap_level state = level_state(l, level);
    const struct shown *s = &l->shown[level];
    bool empty = window_rect_empty(state.valid) || shown_empty(s);
    window held = held_of(l, level);
    double row, col;
    window_coordinates(&l->shape, &held, w->lat, w->lon, &row, &col);
    int64_t row0 = held.rect.row0, col0 = held.rect.col0;
    map[0] = (float)(1 / window_step_lat(&held));
    map[1] = (float)(1 / window_step_lon(&l->shape, &held));
    map[2] = (float)(row - (double)row0);
    map[3] = (float)(col - (double)col0);
    if (empty) return;
    torus[0] = (float)((row0 % l->shape.rows + l->shape.rows) % l->shape.rows);
    torus[1] = (float)((col0 % l->shape.cols + l->shape.cols) % l->shape.cols);
    torus[2] = s->fade;
    torus[3] = (float)window_widening(&l->shape, &held, w->lat, w->ring_bound);
    valid[0] = (float)(s->row0 - (double)row0);
    valid[1] = (float)(s->row1 - (double)row0);
    bool circle = whole_circle(&held) && s->col1 - s->col0 == l->shape.cols;
    valid[2] = circle ? -1e9f : (float)(s->col0 - (double)col0);
    valid[3] = circle ? 1e9f : (float)(s->col1 - (double)col0);
}

window windows_held(const struct windows *w, int level)
{
    return held_of(&w->height, level);
}

window_shape windows_height_samples(const struct windows *w)
{
    return w->height.shape;
}

void windows_fill_block(const struct windows *w, struct levels_block *b)
{
    memset(b, 0, sizeof *b);
    for (int i = 0; i < w->height.levels; i++)
        fill_level(w, &w->height, i, b->height_map[i], b->height_torus[i], b->height_valid[i]);
    for (int i = 0; i < w->color.levels; i++)
        fill_level(w, &w->color, i, b->color_map[i], b->color_torus[i], b->color_valid[i]);
}

void windows_height_bounds(const struct windows *w, int level, double *low, double *high)
{
    // From the finest window that the band's inner ring is sampled by to what its outer ring blends
    // to; further down while one of those does not cover its ring alone.
    int inner = finest_of(w, level), outer = window_of(w, level);
    *low = INFINITY;
    *high = -INFINITY;
    int whole = 0;
    for (int i = inner; i >= 0 && whole < 2; i--) {
        clipmap_level s = level_state(&w->height, i);
        *low = fmin(*low, s.min);
        *high = fmax(*high, s.max);
        whole += i <= outer && s.complete && shown_whole(&w->height.shown[i], &s);
    }
    if (whole < 2) {
        *low = fmin(*low, 0);
        *high = fmax(*high, 0);
    }
}
